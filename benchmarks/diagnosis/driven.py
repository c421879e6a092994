"""Diagnoses the cases that tests.hidden_world.driven.write has written, as a user would, without a look at their truth.

    python -m tests.hidden_world.driven.write OUT --count 60 --none 30 --seed S
    python -m stillarm.benchmarks.diagnosis.driven OUT RESULTS [--budget-s S]
    python -m tests.hidden_world.driven.score OUT RESULTS

A case is imported by its description, with a model file where its rig is stated. Several processes may run on the same
RESULTS side by side: each takes the cases that no other has begun.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import tomli_w

from stillarm.common.user_error import UserError

_BUDGET_S = 60.0


def model_of_stated(stated: dict[str, Any]) -> str:
    """A model file's text from a case's stated.json."""
    drive = stated["drive"]
    arm: dict[str, Any] = {"length_m": stated["arm"]["length_m"]}
    if stated["arm"]["clamped_modes"]:
        arm["modes"] = stated["arm"]["clamped_modes"]
    return tomli_w.dumps(
        {
            "arm": arm,
            "drive": {
                "kind": drive["kind"],
                "inertia_kg_m2": drive["inertia_kg_m2"],
                "torque_per_input": drive["torque_per_command_n_m"],
                "viscous_n_m_s": drive["viscous_n_m_s"],
                "back_emf_n_m_s": drive["back_emf_n_m_s"],
                "gear_ratio": drive["gear_ratio"],
                "amplifier_lag_s": drive["lag_s"],
                "input_limit": drive["limit"],
            },
        }
    )


def answer(case: Path, folder: Path, budget_s: float) -> str | None:
    """Diagnose a case into a folder; returns what was said, None where another process has begun it."""
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        return None
    table = next(one for one in sorted(case.iterdir()) if one.name in ("log.csv", "log.mat"))
    recording = folder / "recording.mcap"
    _stillarm("import", table, "--as", case / "description.toml", "-o", recording)
    model: tuple[Path | str, ...] = ()
    if (case / "stated.json").is_file():
        (folder / "model.toml").write_text(model_of_stated(json.loads((case / "stated.json").read_text())))
        model = ("--model", folder / "model.toml")
    return _stillarm("diagnose", recording, *model, "--no-use", "--budget-s", str(budget_s), "--out", folder)


def _stillarm(*arguments: Path | str) -> str:
    """Run the command; returns its last word, on standard output or error."""
    done = subprocess.run(
        [sys.executable, "-m", "stillarm", *map(str, arguments)], capture_output=True, text=True, check=False
    )
    return (done.stdout or done.stderr).splitlines()[0] if done.stdout or done.stderr else ""


def main() -> None:
    """Answer every case of OUT. Raises UserError where there is none."""
    parser = argparse.ArgumentParser(
        prog="python -m stillarm.benchmarks.diagnosis.driven", description=__doc__
    )
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("results", type=Path, metavar="RESULTS")
    parser.add_argument("--budget-s", type=float, default=_BUDGET_S, metavar="S")
    given = parser.parse_args()
    cases = sorted(given.out.glob("case_*"))
    if not cases:
        raise UserError(f"{given.out}: holds no case_*; write some with tests.hidden_world.driven.write")
    for case in cases:
        said = answer(case, given.results / case.name, given.budget_s)
        if said is not None:
            print(f"{case.name}: {said}", flush=True)


if __name__ == "__main__":
    main()
