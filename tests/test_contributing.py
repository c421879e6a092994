"""CONTRIBUTING.md's steps for a method and a cause, done in a copy of the program."""

import re
from pathlib import Path

import pytest

from tests.fixtures.imports import ROOT
from tests.fixtures.program_copy import program, python, stillarm

__all__ = ["program"]
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")

pytestmark = pytest.mark.slow


def block(path: str) -> str:
    """The code block whose first line names `path`."""
    (found,) = re.findall(rf"```python\n# {re.escape(path)}\n(.*?)```", PAGE, re.S)
    return str(found)


def test_a_method_is_a_file_and_an_entry(program: Path, tmp_path: Path) -> None:
    file = "controller/estimation/last_image.py"
    (program / file).write_text(block(file))
    table = program / "controller" / "estimation" / "methods.py"
    entry = block("controller/estimation/methods.py: METHODS")
    text = table.read_text().replace(
        '    "fused": _fused,\n',
        f'    "fused": _fused,\n{entry}',
    )
    table.write_text(
        text.replace(
            "from stillarm.controller.estimation.sine_method",
            "from stillarm.controller.estimation.last_image import LastImage\n"
            "from stillarm.controller.estimation.sine_method",
        )
    )
    bundle = tmp_path / "bundle"
    bundle.mkdir()
    cycles = "".join(f"{0.001 * n:.3f},0.1\n" for n in range(300))
    (bundle / "fast.csv").write_text(f"time_s,acceleration_m_s2\n{cycles}")
    frames = "".join(f"{n},{0.08 + 0.015 * n:.3f},{0.015 * n:.3f},{n - 4.0}\n" for n in range(10))
    (bundle / "frames.csv").write_text(f"frame,received_s,started_s,displacement_px\n{frames}")
    (bundle / "model.toml").write_text("[arm]\nlength_m = 2.0\n")
    stillarm(program, "import", str(bundle), "-o", "rec.mcap")
    said = stillarm(program, "replay", "rec.mcap", "--method", "last_image", "--out", "replay")
    assert "last_image: 10 frames, delay 80.0 +- 0.0 ms" in said
    assert ",last_image,estimated," in (program / "replay" / "estimates.csv").read_text()


def test_a_cause_is_a_file(program: Path) -> None:
    file = "common/causes/steady_pull.py"
    (program / file).write_text(block(file))
    assert "steady_pull" in stillarm(program, "causes")
    assert "force_per_mass_m_s2" in stillarm(program, "causes", "steady_pull")
    bent = """
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.simulation.arm.plant import Plant
effect = {"cause": "steady_pull", "force_per_mass_m_s2": 0.4}
plant = Plant(Model(arm=Arm(length_m=2.0, modes=[Mode(frequency_hz=2.0, damping_ratio=0.3)]), effects=[effect]))
for _ in range(6000):
    plant.advance(0.0)
print(plant.deflection_m)
"""
    assert float(python(program, bent)) == pytest.approx(0.4 / (2.0 * 3.141592653589793 * 2.0) ** 2, rel=1e-6)
