"""Damping at its limit, with and without success."""

import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Damping
from stillarm.controller.safety.table import Event, State
from tests.fixtures.safety_loop import MODEL, run, states, wrong_participation


@pytest.mark.slow
def test_saturation_without_success_is_a_fault_and_with_success_none() -> None:
    """With a limit of 4 mm/s a large impact takes seconds to damp at the limit; a drive of the wrong sense
    never succeeds.
    """
    damping = Damping(max_velocity_rad_s=0.004)
    settings = Settings(arm_at_start=True, method="correlation", damping=damping)
    sound = run(lambda read: None, 6.0, settings, strikes={0.5: 0.03}, reference=lambda t: 0.0)
    assert states(sound, 0.5, 6.0) == {(State.DAMPING, None)}
    wrong = run(
        lambda read: None, 9.0, settings, wrong_participation(MODEL), {0.5: 0.03}, reference=lambda t: 0.0
    )
    faults = [output.reason for output in wrong.outputs if output.state is State.FAULT]
    assert faults and faults[0] in (Event.SATURATED, Event.GROWING)
