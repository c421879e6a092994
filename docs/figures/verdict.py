"""The evidence by which a diagnosis names a stiffness that grows with the deflection."""

from pathlib import Path

from runs import MODEL
from style import save

import stillarm


def draw(path: Path) -> None:
    """docs/images/verdict.svg"""
    from msgspec.structs import replace

    known = stillarm.Model.read(MODEL)
    true = replace(known, effects=[{"cause": "cubic_stiffness", "coefficient_per_m2": 800.0}])
    run = stillarm.simulate(true, "demo", 3, assumed=known)
    found = stillarm.diagnose(run.recording.path, budget_s=None)
    print(found)
    save(found.plot(), path)
