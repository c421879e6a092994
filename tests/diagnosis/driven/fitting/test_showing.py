"""What the blocks show side by side against the simulation of one block after the other."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.fitting.derivatives import cost_of
from stillarm.diagnosis.driven.fitting.showing import shown
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.signals import Driven, Output

SAMPLES, ACCELERATION = 300, "acceleration_m_s2"
KINDS = {
    "joint_position_rad": "position",
    "joint_velocity_rad_s": "velocity",
    "deflection_m": "deflection",
    ACCELERATION: "acceleration",
}
NUMBERS = {
    "gain": 3.0, "damping": 1.5, "delay": 0.004, "log_w_1": 3.0, "zeta_1": 0.02, "follows_1": 0.7, "carries_1": 0.3,
    "log_w_2": 4.0, "zeta_2": 0.01, "follows_2": -0.2, "carries_2": 0.1, f"direct {ACCELERATION}": 0.5,
    f"share_2 {ACCELERATION}": 0.4, "offset joint_velocity_rad_s": 0.3, "scale deflection_m": 1.2,
}  # fmt: skip
FURTHER_MODES = {
    f"{name}_{i}": value
    for i in range(3, 7)
    for name, value in (("log_w", 3.0 + 0.4 * i), ("zeta", 0.02), ("follows", 0.3), ("carries", 0.05))
}
CASES: dict[str, dict[str, float]] = {
    "linear": {},
    "held": {"held": 1.0, "lag": 0.01, "dead_zone": 0.1, "limit": 1.0},
    "half a jump": {"held": 1.0, f"jump {ACCELERATION}": 0.5},
    "half a jump beside a late angle": {
        "held": 1.0,
        f"jump {ACCELERATION}": 0.5,
        "delay joint_position_rad": 0.007,
    },
    "friction": {"coulomb": 0.5, "coulomb_difference": 0.1, "stribeck": 0.2, "log_stribeck_velocity": -1.0},
    "forces": {
        "viscous_square": 0.1,
        "ripple_sine": 0.3,
        "ripple_cycles": 9.0,
        "gravity_cosine": 0.5,
        "offset": 0.1,
    },
    "arm": {"arm_cubic": 50.0, "arm_coulomb": 0.05, "inertia_excess": 0.2},
    "onset": {"inertia_step": 0.4, "onset": 2.0, "coulomb": 0.2},
    "late velocity": {"lag joint_velocity_rad_s": 0.02, "delay joint_position_rad": 0.007},
    "late arm": {f"lag {ACCELERATION}": 0.004, f"delay {ACCELERATION}": 0.005, "delay deflection_m": -0.003},
}


def _box(step_s: float, modes: int = 2) -> GreyBox:
    """Four blocks, of which no two are as long, with samples that nobody measured."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=(len(KINDS), SAMPLES))
    values[0, 40:60] = np.nan
    outputs = tuple(
        Output(name, kind, one, True, 0.0)  # type: ignore[arg-type]
        for (name, kind), one in zip(KINDS.items(), values, strict=True)
    )
    driven = Driven("x", step_s, 0.0, "motor_current_command_a", rng.normal(size=SAMPLES), True, outputs, {})
    edges = step_s * np.array([0.0, 70.0, 141.0, 200.0, SAMPLES])
    return GreyBox(driven, Split(edges, np.array([False, True, False, False])), modes)


@pytest.mark.parametrize("step_s", [0.002, 0.02])
@pytest.mark.parametrize("case", CASES)
def test_blocks_side_by_side_show_what_they_show_one_by_one(case: str, step_s: float) -> None:
    box, numbers = _box(step_s), NUMBERS | CASES[case]
    states = 0.1 * np.random.default_rng(4).normal(size=(4, box.size))
    run = box.run(numbers, states)
    sigma = dict(zip(KINDS, (0.1, 0.2, 0.3, 4.0), strict=True))
    wanted = box.stack.of([run.outputs[name] / sigma[name] for name in KINDS])
    assert shown(box, numbers, states, sigma) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("modes", range(7))
def test_an_arm_may_have_as_many_modes_as_it_likes(modes: int) -> None:
    box, states = _box(0.004, modes), 0.1 * np.random.default_rng(4).normal(size=(4, 2 + 2 * modes))
    numbers = NUMBERS | CASES["friction"] | FURTHER_MODES
    wanted = box.stack.of([box.run(numbers, states).outputs[name] for name in KINDS])
    found = shown(box, numbers, states, dict.fromkeys(KINDS, 1.0))
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


PLAY = {"gap": 0.02, "share": 0.3, "bounce": 0.2, "coulomb": 0.1, "ripple_sine": 0.2, "ripple_cycles": 5.0}


@pytest.mark.parametrize(
    "side",
    [
        {},
        {"rate_on_motor": 1.0},
        {"on_motor": 1.0},
        {"delay deflection_m": 0.003, "delay joint_velocity_rad_s": 0.005},
        {"rate_on_motor": 1.0, "lag joint_velocity_rad_s": 0.01, f"lag {ACCELERATION}": 0.004},
        {"on_motor": 1.0, "delay joint_position_rad": -0.003, f"delay {ACCELERATION}": 0.005},
    ],
)
@pytest.mark.parametrize("modes", [0, 2, 4, 6])
def test_blocks_with_play_show_what_they_show_one_by_one(modes: int, side: dict[str, float]) -> None:
    box = replace(_box(0.004, modes), play=True)
    numbers = NUMBERS | FURTHER_MODES | PLAY | side
    states = 0.1 * np.random.default_rng(4).normal(size=(4, box.size))
    outputs = box.run(numbers, states).outputs
    wanted = box.stack.of([outputs[name] for name in KINDS])
    assert shown(box, numbers, states, dict.fromkeys(KINDS, 1.0)) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_a_rigid_joint_has_no_arm() -> None:
    box = _box(0.002).without_arm()
    states = np.ones((4, 2))
    wanted = box.stack.of(list(box.run(NUMBERS, states).outputs.values()))
    assert shown(box, NUMBERS, states, dict.fromkeys(KINDS, 1.0)) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_what_was_not_measured_costs_nothing() -> None:
    box, states = _box(0.002), np.zeros((4, 6))
    sigma = dict.fromkeys(KINDS, 1.0)
    cost, errors = cost_of(box, NUMBERS, states, sigma)
    outputs = box.run(NUMBERS, states).outputs
    train = ~box.split.held[box.block]
    by_hand = sum(np.nansum((one.values - outputs[one.name])[train] ** 2) for one in box.driven.outputs)
    assert cost == pytest.approx(0.5 * by_hand)
    assert np.count_nonzero(errors) == len(KINDS) * SAMPLES - 20


def test_a_block_is_a_slice() -> None:
    box = _box(0.002)
    stacked = box.stack.of([np.arange(SAMPLES) + 1000.0 * k for k in range(len(KINDS))])
    begins, ends = box.stack.bounds[1]
    assert stacked[begins:ends].reshape(4, 71)[:, 0].tolist() == [70.0, 1070.0, 2070.0, 3070.0]
    assert replace(box.stack, starts=box.starts).counts[:, 0].tolist() == [50.0, 71.0, 59.0, 100.0]
