"""Modes that a subspace fit sees, against the rig of a world that shares no code with it."""

import numpy as np
import pytest

from stillarm.diagnosis.driven.recording.regression import joint_numbers
from stillarm.diagnosis.driven.starts.begins import seen_begins
from stillarm.diagnosis.driven.starts.subspace import modes_seen
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import Case, make


def _first_mode(case: Case) -> tuple[float, float]:
    """Angular frequency of the held arm's first mode, and the inertia that it carries over the hub's."""
    arm = case.rig.arm
    modes = arm.clamped_modes()
    carried = [one["modal_mass_kg"] * (one["participation"] * arm.length_m) ** 2 for one in modes]
    return 2.0 * np.pi * modes[0]["frequency_hz"], carried[0] / (case.rig.inertia - sum(carried))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [424200006, 424200046])
def test_a_lightly_damped_arm_is_seen_at_its_clamped_frequency(seed: int) -> None:
    """The second is seen by its deflection alone: only the free hub's frequency shows there."""
    case = make(seed, "none")
    driven = driven_of(case)
    w, carries = _first_mode(case)
    seen = [modes[0] for modes in modes_seen(driven, 1)]
    if any(one.kind in ("position", "motor", "velocity") for one in driven.outputs):
        best = min(seen, key=lambda one: abs(np.log(one.w / w)) + 0.2 * abs(np.log(one.carries / carries)))
        assert best.w == pytest.approx(w, rel=0.03)
        assert best.carries == pytest.approx(carries, rel=0.15)
    else:
        free = [one.w * np.sqrt(1.0 + one.carries) for one in seen]
        lowest = w * np.sqrt(1.0 + carries)
        assert min(abs(one / lowest - 1.0) for one in free) < 0.05


@pytest.mark.slow
def test_the_numbers_that_a_fit_begins_with_hold_the_hubs_own_gain() -> None:
    case = make(424200006, "none")
    driven = driven_of(case)
    w, carries = _first_mode(case)
    begins = list(seen_begins(driven, joint_numbers(driven), 1))
    best = min(
        begins, key=lambda one: abs(one["log_w_1"] - np.log(w)) + abs(np.log(one["carries_1"] / carries))
    )
    arm = case.rig.arm.clamped_modes()
    carried = sum(one["modal_mass_kg"] * (one["participation"] * case.rig.arm.length_m) ** 2 for one in arm)
    hub = case.rig.inertia - carried
    assert best["gain"] == pytest.approx(case.rig.drive.gain / hub, rel=0.15)
