"""Derivatives that are told without a simulation of their own, against differences."""

import numpy as np
import pytest

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting.derivatives import cost_of, derivatives, levels_of, rescaled
from stillarm.diagnosis.driven.fitting.showing import shown
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.signals import Driven, Output

SAMPLES, STEP_S = 300, 0.01
NUMBERS = {
    "gain": 3.0, "damping": 1.5, "delay": 0.004, "log_w_1": 3.0, "zeta_1": 0.02, "follows_1": 0.7, "carries_1": 0.3,
    "offset joint_velocity_rad_s": 0.3, "scale deflection_m": 1.2,
}  # fmt: skip
SIGMA = {"joint_position_rad": 0.1, "joint_velocity_rad_s": 0.2, "deflection_m": 0.05}
FREE = ("gain", "offset joint_velocity_rad_s")


def _box() -> GreyBox:
    """Blocks of different lengths, with samples that nobody measured."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(3, SAMPLES))
    values[0, 40:60] = np.nan
    kinds = ("position", "velocity", "deflection")
    outputs = tuple(
        Output(name, kind, one, True, 0.0)  # type: ignore[arg-type]
        for name, kind, one in zip(SIGMA, kinds, values, strict=True)
    )
    driven = Driven("x", STEP_S, 0.0, "motor_current_command_a", rng.normal(size=SAMPLES), True, outputs, {})
    edges = STEP_S * np.array([0.0, 70.0, 141.0, 200.0, SAMPLES])
    return GreyBox(driven, Split(edges, np.array([False, True, False, False])), 1)


@pytest.mark.parametrize("law", [{}, {"viscous_square": 0.1}, {"lag deflection_m": 0.02}])
def test_each_block_is_told_by_its_state_and_by_an_offset_as_differences_have_it(
    law: dict[str, float],
) -> None:
    box, numbers = _box(), NUMBERS | law
    states = 0.1 * np.random.default_rng(4).normal(size=(4, box.size))
    _, errors = cost_of(box, numbers, states, SIGMA)
    pieces = derivatives(box, numbers, FREE, states, SIGMA, errors)
    base, known = (
        shown(box, numbers, states, SIGMA),
        box.stack.of([np.isfinite(one.values) for one in box.driven.outputs]),
    )
    step = 1e-3
    for place in range(box.size):
        wanted = known * (shown(box, numbers, states + step * np.eye(box.size)[place], SIGMA) - base) / step
        found = np.concatenate([one.by_state[:, place] for one in pieces])
        assert np.abs(found - wanted).max() < 0.02 * np.abs(wanted).max()
    more = {**numbers, FREE[1]: numbers[FREE[1]] + step}
    wanted = known * (shown(box, more, states, SIGMA) - base) / step
    assert np.concatenate([one.by_numbers[:, 1] for one in pieces]) == pytest.approx(wanted, abs=1e-8)


def test_other_deviations_ask_for_no_other_simulation() -> None:
    box, states = _box(), np.zeros((4, 4))
    _, errors = cost_of(box, NUMBERS, states, SIGMA)
    levels = levels_of(box, errors, SIGMA)
    cost, scaled = rescaled(box, errors, SIGMA, levels)
    wanted, by_hand = cost_of(box, NUMBERS, states, levels)
    assert cost == pytest.approx(wanted)
    assert scaled == pytest.approx(by_hand)
