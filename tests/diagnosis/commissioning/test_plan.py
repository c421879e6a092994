"""No move of a plan goes beyond its limits, whatever they are and whatever arm it is for; and none damps."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.model import Drive, Mode
from stillarm.common.files.scenario import Scenario
from stillarm.common.user_error import UserError
from stillarm.diagnosis.commissioning.plan import Limits, moves, probe, slowed, stages, within

CYCLE_S = 0.004
LIMITS = st.builds(
    Limits,
    angle_rad=st.floats(0.002, 0.3),
    velocity_rad_s=st.floats(0.005, 1.0),
    acceleration_rad_s2=st.floats(1.0, 50.0),
)
MODES = st.builds(Mode, frequency_hz=st.floats(0.8, 12.0), damping_ratio=st.floats(0.001, 0.05))


def obeys(plan: Scenario, limits: Limits) -> None:
    """By the reference itself, cycle by cycle."""
    times = np.arange(round(plan.duration_s / CYCLE_S)) * CYCLE_S
    velocity = np.array([plan.reference_rad_s(float(t)) for t in times])
    angle = np.cumsum(velocity) * CYCLE_S
    assert np.max(np.abs(velocity)) <= limits.velocity_rad_s * (1.0 + 1e-9)
    assert np.max(np.abs(angle)) <= limits.angle_rad + limits.velocity_rad_s * 3.0 * CYCLE_S
    assert np.max(np.abs(np.diff(velocity))) / CYCLE_S <= limits.acceleration_rad_s2 * (1.0 + 1e-6)
    assert abs(angle[-1]) <= limits.velocity_rad_s * 20.0 * CYCLE_S
    assert velocity[0] == velocity[-1] == 0.0
    assert not plan.damping and not plan.strikes


@settings(max_examples=10, deadline=None)
@given(limits=LIMITS)
def test_the_probe_obeys_its_limits(limits: Limits) -> None:
    limits = within(limits, Drive())
    obeys(probe(limits), limits)
    speeds = [stage.velocity_rad_s for stage in stages(limits)]
    assert all(1.0 < later / earlier <= 2.0 + 1e-9 for earlier, later in pairwise(speeds))


@settings(max_examples=10, deadline=None)
@given(limits=LIMITS, mode=MODES, share=st.floats(0.05, 1.0))
def test_the_moves_obey_their_limits(limits: Limits, mode: Mode, share: float) -> None:
    limits = within(limits, Drive())
    plan = moves(limits, share * limits.velocity_rad_s, mode)
    obeys(plan, limits)
    obeys(slowed(plan, 0.5), limits)
    assert plan.duration_s < 150.0


def test_the_drive_s_own_limits_are_the_narrower_ones() -> None:
    limits = within(Limits(), Drive(max_velocity_rad_s=0.05, min_position_rad=-0.01, max_position_rad=0.01))
    assert limits.velocity_rad_s == 0.05 and limits.angle_rad == 0.01


def test_no_room_is_one_line() -> None:
    with pytest.raises(UserError, match="leave no room for a move") as refused:
        within(Limits(velocity_rad_s=0.001), Drive())
    assert "\n" not in str(refused.value)


def test_rest_for_an_impact_comes_at_the_end() -> None:
    mode = Mode()
    assert moves(Limits(), 0.1, mode, 10.0).duration_s == pytest.approx(
        moves(Limits(), 0.1, mode).duration_s + 10.0
    )
