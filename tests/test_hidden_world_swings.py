"""The generator of swings is right by measures of its own: a general integrator, its laws, its seed."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.hidden_world.swings.arrivals import images, serve
from tests.hidden_world.swings.bundle import write_bundle
from tests.hidden_world.swings.draw import KINDS, draw
from tests.hidden_world.swings.informed import informed_error
from tests.hidden_world.swings.motion import force, move
from tests.hidden_world.swings.plain import draw_plain
from tests.hidden_world.swings.rig import STEP_S, TICK_S, Case, Event
from tests.hidden_world.swings.sensors import free_spans, make


def short(case: Case, *events: Event) -> Case:
    """Three seconds of a case, with these events alone."""
    return replace(case, duration_s=3.0, events=events)


@pytest.mark.slow
@pytest.mark.parametrize(
    "event",
    [
        Event("pull", 0.2, 0.01, ramp_s=0.7, hold_s=0.5),
        Event("push", 0.3, 0.01, ramp_s=0.21),
        Event("strike", 0.3, 0.01, ramp_s=0.004),
        Event("rock", 0.3, 0.01, hold_s=1.2, ratio=0.97),
        Event("move", 0.2, 0.1, ramp_s=0.6),
    ],
    ids=lambda event: event.kind,
)
def test_motion_is_what_a_general_integrator_gives(event: Event) -> None:
    case = short(draw(1000), event)  # two modes
    assert len(case.modes) == 2
    motion = move(case)
    after, before = force(case, motion.time_s)
    lag = 2.0 * np.pi * case.joint.bandwidth_hz

    def slope(t: float, x: np.ndarray) -> np.ndarray:
        cycle = int((t - case.joint.dead_time_s) / TICK_S) if t >= case.joint.dead_time_s else -1
        command = motion.command_rad_s[min(cycle, len(motion.command_rad_s) - 1)] if cycle >= 0 else 0.0
        joint = lag * (command - x[1])
        k = min(int(t / STEP_S), len(after) - 2)
        push = after[k] + (before[k + 1] - after[k]) * (t / STEP_S - k)
        out = [x[1], joint]
        for number, mode in enumerate(case.modes):
            w = 2.0 * np.pi * mode.frequency_hz
            q, rate = x[2 + 2 * number : 4 + 2 * number]
            drive = mode.push * push - mode.participation * case.length_m * joint
            out += [rate, drive - w * w * q - 2.0 * mode.damping_ratio * w * rate]
        return np.array(out)

    ends = np.arange(0, 30000, 1000)
    solved = solve_ivp(
        slope, (0.0, 2.9), np.zeros(6), t_eval=motion.time_s[ends[:-1]], max_step=2e-4, rtol=1e-8, atol=1e-12
    )
    bend = solved.y[2] + solved.y[4]
    scale = np.max(np.abs(bend))
    assert scale > 1e-4
    assert np.max(np.abs(motion.deflection_m[ends[:-1]] - bend)) < 2e-3 * scale
    assert np.max(np.abs(motion.theta_rad[ends[:-1]] - solved.y[0])) < 1e-4


def test_a_release_lets_the_arm_swing_by_what_it_was_pulled() -> None:
    case = short(draw_plain(1002), Event("pull", 0.2, 0.01, ramp_s=1.0, hold_s=0.5))
    motion = move(case)
    held = motion.deflection_m[int(1.69 / STEP_S)]
    swung = np.max(np.abs(motion.deflection_m[int(1.71 / STEP_S) :]))
    assert held == pytest.approx(0.01, rel=0.15)  # the hand wavers, and the arm with it
    assert swung == pytest.approx(held, rel=0.15)
    assert abs(np.mean(motion.deflection_m[int(1.71 / STEP_S) :])) < 0.1 * swung


def test_an_instant_strike_gives_the_amplitude_it_is_sized_by() -> None:
    case = short(draw_plain(1003), Event("strike", 0.2005, 0.01))
    motion = move(case)
    assert np.max(np.abs(motion.deflection_m)) == pytest.approx(0.01, rel=0.05)
    on_ticks = motion.acceleration_m_s2[:: round(TICK_S / STEP_S)]
    w = 2.0 * np.pi * case.modes[0].frequency_hz
    assert np.max(np.abs(on_ticks)) < 1.1 * 0.01 * w * w  # no sample lies in the impact


def test_acceleration_is_the_second_derivative_of_the_tip() -> None:
    case = short(draw(1000), Event("push", 0.3, 0.01, ramp_s=0.3), Event("move", 1.0, 0.05, ramp_s=0.5))
    motion = move(case)
    second = np.diff(motion.tip_m, 2) / STEP_S**2
    inside = slice(4000, 9000)  # before the joint moves: its acceleration jumps every cycle
    scale = np.max(np.abs(second[inside]))
    assert np.max(np.abs(motion.acceleration_m_s2[1:-1][inside] - second[inside])) < 0.01 * scale


@pytest.mark.parametrize("seed", range(40))
def test_images_come_in_order_and_never_before_the_floor(seed: int) -> None:
    case = draw(seed)
    seen = images(case)
    assert len(seen.number) > 0.8 * case.camera.frame_rate_hz * (case.duration_s - 2.0)
    assert np.all(np.diff(seen.received_s) > -1e-9)
    assert np.all(np.diff(seen.number) > 0)
    assert np.min(seen.received_s - seen.middle_s) >= case.arrivals.floor_s
    assert np.max(np.abs(seen.received_s / TICK_S - np.round(seen.received_s / TICK_S))) < 1e-6


def test_a_stalled_server_lets_the_queue_drain() -> None:
    ready = np.arange(10) * 0.02
    read = serve(ready, 0.005, [(0.03, 0.1)], np.zeros(10, dtype=bool))
    assert np.allclose(read[:5], [0.0, 0.02, 0.1, 0.105, 0.11])
    assert read[-1] == ready[-1]


@pytest.mark.parametrize("seed", range(24))
def test_every_draw_can_be_made_and_judged(seed: int) -> None:
    for case in (draw(seed), draw_plain(seed)):
        assert case.kind == KINDS[seed % len(KINDS)]
        assert case.noise_m * 2.0 < case.amplitude_m <= 0.05 * case.length_m
        spans = free_spans(case)
        assert len(spans) >= 2
        assert all(later[0] >= earlier[1] for earlier, later in pairwise(spans))


def test_a_seed_gives_the_same_files_again(tmp_path: Path) -> None:
    case = replace(draw(1001), duration_s=12.0, events=(Event("strike", 5.0, 0.002, ramp_s=0.005),))
    for name in ("one", "two"):
        write_bundle(make(case), tmp_path / name)
    for file in sorted((tmp_path / "one").iterdir()):
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes(), file.name


def test_who_is_told_all_reaches_what_the_noise_leaves() -> None:
    case = replace(draw_plain(1003), duration_s=12.0)
    case = replace(case, events=(Event("strike", 2.0, case.amplitude_m, ramp_s=0.004),))
    loud = replace(case, camera=replace(case.camera, noise_px=3.0 * case.camera.noise_px))
    loud = replace(
        loud,
        accelerometer=replace(case.accelerometer, noise_m_s2=3.0 * case.accelerometer.noise_m_s2),
    )
    quiet = informed_error(make(case))
    assert 0.0 < quiet < 0.02
    assert informed_error(make(loud)) == pytest.approx(3.0 * quiet, rel=0.01)


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="kind wave: one of pull"):
        draw(0, "wave")
