"""Warming up leaves nothing behind."""

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Arm, Model
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.loop.warm_up import warm_up


def test_a_controller_made_before_is_as_fresh_after() -> None:
    """The first answers with and without a warm-up are the same."""
    model, settings = Model(arm=Arm(length_m=2.0)), Settings()
    answers = []
    for warm in (False, True):
        controller = Controller(model, settings)
        if warm:
            warm_up(model, settings, "model")
        answers.append([controller.step(CycleInput(k, 0.1 * k, 0.0)).command_rad_s for k in range(50)])
    assert answers[0] == answers[1]
