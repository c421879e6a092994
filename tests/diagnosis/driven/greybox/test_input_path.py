"""What reaches the joint when a recording begins: a lag that has settled, or a drive that was switched on with it."""

import json
from pathlib import Path

import numpy as np
import pytest

from stillarm.benchmarks.diagnosis.driven import model_of_stated
from stillarm.common.files.model import load_model
from stillarm.diagnosis.driven.greybox.input_path import STEADY, reaching
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven
from stillarm.diagnosis.driven.search.judging import CONVINCES
from stillarm.diagnosis.driven.search.search import tried_forms
from stillarm.diagnosis.driven.starts.start import linear_start
from stillarm.diagnosis.driven.starts.stated import stated_by
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.files import write_case

STEP_S, LAG_S = 0.01, 0.03


@pytest.mark.parametrize("steady", [0.0, 0.4, 1.0])
def test_a_lag_begins_where_the_input_before_has_left_it(steady: float) -> None:
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", np.full(50, 2.0), True, (), {})
    reached = reaching(driven, {"held": 1.0, "lag": LAG_S, STEADY: steady}, 1)
    time = STEP_S * np.arange(50)
    assert reached[:, 0] == pytest.approx(2.0 * (1.0 - (1.0 - steady) * np.exp(-time / LAG_S)))


@pytest.mark.parametrize("held", [0.0, 1.0])
def test_so_does_a_delay(held: float) -> None:
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", np.full(50, 2.0), True, (), {})
    reached = reaching(driven, {"held": held, "delay": 3.0 * STEP_S, STEADY: 0.0}, 1)
    assert reached[:3, 0] == pytest.approx(0.0) and reached[4:, 0] == pytest.approx(2.0)


@pytest.mark.slow
def test_an_amplifier_that_begins_at_rest_is_no_limit(tmp_path: Path) -> None:
    """A lag of a sample in a closed loop: its first milliseconds have little torque, as with a limit of the input."""
    case = make(7009100003, "none")
    write_case(case, tmp_path / "case")
    stated = json.loads((tmp_path / "case" / "stated.json").read_text())
    (tmp_path / "model.toml").write_text(model_of_stated(stated))
    driven = driven_of(case)
    known = stated_by(load_model(tmp_path / "model.toml"), driven, "model.toml")
    start = linear_start(driven, irregular(driven.duration_s), known)
    assert start.numbers[STEADY] == pytest.approx(0.0, abs=0.1)
    limits = [one.merit for one in tried_forms(start, lambda: 1e9) if one.form.cause == "drive_saturation"]
    assert max(limits, default=0.0) < CONVINCES
