"""Diagnoses the cases that tests.hidden_world.driven.write has written, as a user would, without a look at their truth.

    python -m tests.hidden_world.driven.write OUT --count 60 --none 30 --seed S
    python -m stillarm.benchmarks.diagnosis.driven OUT RESULTS [--budget-s S]
    python -m tests.hidden_world.driven.score OUT RESULTS

A case is imported by its description, with a model file where its rig is stated. Several processes may run on the same
RESULTS side by side: each takes the cases that no other has begun.
"""

import json
from pathlib import Path
from typing import Any

import tomli_w

from stillarm.benchmarks.diagnosis.cases import answer_all, stillarm


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


def answer(case: Path, folder: Path, budget_s: float) -> str:
    """Diagnose a case into a folder; returns what was said."""
    recording = folder / "recording.mcap"
    table = next(one for one in sorted(case.iterdir()) if one.name in ("log.csv", "log.mat"))
    stillarm("import", table, "--as", case / "description.toml", "-o", recording)
    model: tuple[Path | str, ...] = ()
    if (case / "stated.json").is_file():
        (folder / "model.toml").write_text(model_of_stated(json.loads((case / "stated.json").read_text())))
        model = ("--model", folder / "model.toml")
    return stillarm("diagnose", recording, *model, "--no-use", "--budget-s", str(budget_s), "--out", folder)


if __name__ == "__main__":
    answer_all(answer, "tests.hidden_world.driven.write")
