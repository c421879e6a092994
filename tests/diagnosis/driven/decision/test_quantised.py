"""An encoder's steps, and what counts beside them."""

import json
from pathlib import Path

import numpy as np
import pytest

from stillarm.benchmarks.diagnosis.driven import model_of_stated
from stillarm.common.files.model import load_model
from stillarm.diagnosis.driven.decision.decide import decide
from stillarm.diagnosis.driven.decision.quantised import CAUSE, beyond_half_a_step, quantised
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output, counter_step
from stillarm.diagnosis.driven.search.search import search
from stillarm.diagnosis.driven.starts.stated import stated_by
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.files import write_case

STEP_S, NAME, COUNT = 0.01, "joint_position_rad", 0.2
NUMBERS = {"gain": 1.0, "damping": 0.5}


def _fitted(torque: float) -> DrivenFit:
    """A joint whose angle is counted in coarse steps, fitted without a constant torque that it may have."""
    u = np.random.default_rng(4).standard_normal(2000)
    u = np.convolve(u, np.ones(60) / 10.0, mode="same")
    blind = Output(NAME, "position", np.zeros(2000), True, COUNT)
    driven = Driven("x", STEP_S, 0.0, "joint_torque_n_m", u, True, (blind,), {})
    split = irregular(driven.duration_s)
    free = GreyBox(driven, split)
    angle = free.run({**NUMBERS, "offset": torque}, np.zeros((len(split.held), 2))).outputs[NAME]
    counted = COUNT * np.rint(angle / COUNT)
    seen = Output(NAME, "position", counted, True, counter_step(counted))
    box = GreyBox(Driven("x", STEP_S, 0.0, "joint_torque_n_m", u, True, (seen,), {}), split)
    return fit(box, NUMBERS, (), np.zeros((len(split.held), 2)), steps=0)


def test_a_counted_angle_is_named_by_its_step() -> None:
    found = quantised(_fitted(0.0))
    assert found is not None
    form, channel, step, reduction = found
    assert form.cause == CAUSE and channel == NAME and abs(step / COUNT - 1.0) < 1e-6 and reduction > 0.2


def test_what_rounding_leaves_is_no_departure_and_what_is_more_than_that_stays_one() -> None:
    rounded, off = _fitted(0.0), _fitted(3.0)

    def lost(fitted: DrivenFit) -> float:
        return float((beyond_half_a_step(fitted, NAME).whole - fitted.whole).sum())

    exact = beyond_half_a_step(rounded, NAME)
    assert (exact.whole >= beyond_half_a_step(off, NAME).whole).all()
    assert lost(rounded) >= 0.0
    assert float(exact.whole.sum() - beyond_half_a_step(off, NAME).whole.sum()) > 100.0


@pytest.mark.slow
def test_what_makes_up_for_some_of_the_rounding_is_not_told_beside_it(tmp_path: Path) -> None:
    """A constant torque takes away 1 % of the velocity's error here: the steps bend the fit by as much."""
    case = make(7009500008, CAUSE)
    write_case(case, tmp_path / "case")
    stated = json.loads((tmp_path / "case" / "stated.json").read_text())
    (tmp_path / "model.toml").write_text(model_of_stated(stated))
    driven = driven_of(case)
    known = stated_by(load_model(tmp_path / "model.toml"), driven, "model.toml")
    found = search(driven, irregular(driven.duration_s), lambda done, what: None, stated=known)
    verdict = decide(found)
    assert verdict.verdict == "named" and [one.form.cause for one in verdict.findings] == [CAUSE]
