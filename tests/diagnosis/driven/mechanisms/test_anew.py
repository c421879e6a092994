"""A large torque that draws the start astray is sought from where the start began."""

import json
from pathlib import Path

import pytest

from stillarm.benchmarks.diagnosis.driven import model_of_stated
from stillarm.common.files.model import load_model
from stillarm.diagnosis.driven.fitting.fitting import fit
from stillarm.diagnosis.driven.mechanisms.anew import anew_with
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.starts.start import linear_start
from stillarm.diagnosis.driven.starts.stated import stated_by
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.files import write_case


@pytest.mark.slow
def test_a_constant_torque_in_a_closed_loop_leads_back_to_the_arm_that_is_there(tmp_path: Path) -> None:
    """A fifth of the motor's torque holds on. Without it a linear fit loses the arm's mode for good."""
    case = make(70001000001, "torque_offset")
    assert case.effect is not None
    write_case(case, tmp_path / "case")
    stated = json.loads((tmp_path / "case" / "stated.json").read_text())
    (tmp_path / "model.toml").write_text(model_of_stated(stated))
    driven = driven_of(case)
    known = stated_by(load_model(tmp_path / "model.toml"), driven, "model.toml")
    assert known is not None
    start = linear_start(driven, irregular(driven.duration_s), known)
    (begun,) = anew_with("offset")(start)
    found = fit(start.box, begun, (*start.free, "offset"), start.states)
    hub = known.numbers["hub_inertia_kg_m2"]
    assert hub * found.numbers["offset"] == pytest.approx(case.effect.sign * case.effect.size, rel=0.01)
    assert found.numbers["log_w_1"] == pytest.approx(known.numbers["log_w_1"], abs=0.02)
    assert list(anew_with("offset")(found)) == []  # once only: a cause is in the model
