"""A rig whose model is stated: what its sensors see in their own units is held against the model."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from stillarm.benchmarks.diagnosis.driven import model_of_stated
from stillarm.common.files.model import load_model
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.search.search import tried_forms
from stillarm.diagnosis.driven.starts.start import linear_start
from stillarm.diagnosis.driven.starts.stated import stated_by
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.files import write_case


@pytest.mark.blind(each_run=1, group="driven joints")
@pytest.mark.parametrize(
    "seed, cause, unknown",
    [
        (6172500043, "sensor_scale", "command"),  # of the angle; the command is in per cent
        (9081700008, "joint_viscous_friction", "velocity"),  # a tachometer in volts, a bending in metres
        (
            7008000013,
            "joint_viscous_friction",
            "",
        ),  # 2 %; the squares of a fit weigh other frequencies than the score
        (7009500001, "sensor_lag", ""),  # of a velocity, ten samples: each block begins with what it showed
        (7009100009, "gravity_load", ""),  # a velocity alone shows over which angle it acts
        (7009100022, "joint_coulomb_friction", ""),  # an accelerometer alone, on an arm that does not bend
        (7009100024, "joint_stribeck_friction", ""),  # else the stated modes go down to 0.1 Hz in its place
    ],
)
def test_what_a_stated_rig_sees_in_its_own_size_is_a_cause(
    seed: int, cause: str, unknown: str, tmp_path: Path
) -> None:
    case = make(seed, cause)
    write_case(case, tmp_path / "case")
    stated = json.loads((tmp_path / "case" / "stated.json").read_text())
    (tmp_path / "model.toml").write_text(model_of_stated(stated))
    driven = driven_of(case)
    raw = tuple(
        replace(one, stated=False, values=16.8 * one.values) if one.kind == unknown else one
        for one in driven.outputs
    )
    driven = replace(driven, outputs=raw, drive_stated=unknown != "command")
    known = stated_by(load_model(tmp_path / "model.toml"), driven, "model.toml")
    start = linear_start(driven, irregular(driven.duration_s), known)
    assert tried_forms(start, lambda: 1e9)[0].form.cause == cause
