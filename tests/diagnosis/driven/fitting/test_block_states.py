"""Initial states of blocks where a joint rubs: one that sticks begins anew from what the sensors tell."""

import numpy as np

from stillarm.diagnosis.driven.fitting.block_states import begun_states, settled_states
from stillarm.diagnosis.driven.fitting.derivatives import by_block, cost_of
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output

STEP_S, SAMPLES, NOISE = 0.01, 900, 1e-4
NUMBERS = {"gain": 1.0, "damping": 0.5, "coulomb": 1.0}
SIGMA = {"joint_position_rad": NOISE}


def _coasting() -> tuple[GreyBox, np.ndarray]:
    """A joint that rubs, without an input for its friction to yield to: what moves it is how fast each block begins."""
    split = irregular(SAMPLES * STEP_S)
    blind = Output("joint_position_rad", "position", np.zeros(SAMPLES), True, 0.0)
    box = GreyBox(Driven("x", STEP_S, 0.0, "joint_torque_n_m", np.zeros(SAMPLES), True, (blind,), {}), split)
    states = np.column_stack(
        [np.linspace(-0.2, 0.3, len(split.held)), np.linspace(0.4, 0.9, len(split.held))]
    )
    angle = box.run(NUMBERS, states).outputs["joint_position_rad"]
    seen = Output("joint_position_rad", "position", angle, True, 0.0)
    return GreyBox(
        Driven("x", STEP_S, 0.0, "joint_torque_n_m", np.zeros(SAMPLES), True, (seen,), {}), split
    ), states


def _worst(box: GreyBox, states: np.ndarray) -> float:
    """Of all blocks, rms over the noise."""
    squares = by_block(box, cost_of(box, NUMBERS, states, SIGMA)[1])
    return float(np.sqrt(np.max(squares / np.bincount(box.block))))


def test_a_block_that_sticks_begins_anew_from_what_the_sensors_tell() -> None:
    box, true = _coasting()
    stuck = true * [1.0, 0.0]
    alone = settled_states(box, NUMBERS, stuck, SIGMA, 10)
    assert _worst(box, alone) > 100.0  # at rest no derivative by the velocity shows anything
    assert (
        _worst(box, settled_states(box, NUMBERS, begun_states(box, NUMBERS, stuck, SIGMA), SIGMA, 10)) < 1.0
    )


def test_a_state_that_does_better_than_the_sensors_stays() -> None:
    box, true = _coasting()
    assert np.array_equal(begun_states(box, NUMBERS, true, SIGMA), true)


def test_components_that_are_not_given_are_as_the_sensors_tell() -> None:
    box, true = _coasting()
    assert np.array_equal(begun_states(box, NUMBERS, None, SIGMA), box.first_states(NUMBERS))
    given = begun_states(box, NUMBERS, true[:, :1], SIGMA)
    assert np.array_equal(given[:, 1], box.first_states(NUMBERS)[:, 1])


def test_no_step_makes_a_block_worse() -> None:
    box, true = _coasting()
    off = true + np.array([0.05, -0.3])
    before, after = (
        by_block(box, cost_of(box, NUMBERS, one, SIGMA)[1])
        for one in (off, settled_states(box, NUMBERS, off, SIGMA, 1))
    )
    assert (after <= before).all()
