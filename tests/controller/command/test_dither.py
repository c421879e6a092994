"""The dither is always bounded, stays away from the modes, and suffices to date the camera without an
accelerometer.
"""

from math import nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.benchmarks.estimators.trial import LENGTH_M, assumed_model, visual_sample
from stillarm.benchmarks.estimators.world.generator import expose
from stillarm.benchmarks.estimators.world.plant import amplitude_m, arm_plant, strike
from stillarm.benchmarks.estimators.world.regimes import REGIMES, Arm
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Dither
from stillarm.common.user_error import UserError
from stillarm.controller.command.dither import STILL, check_dither, dither_on, highest_velocity_rad_s
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.replay.frame_delays import FrameDelays

CYCLE_S = 0.001


@given(
    st.lists(st.tuples(st.booleans(), st.integers(1, 400)), min_size=1, max_size=200),
    st.floats(1e-4, 0.02), st.floats(0.1, 20.0), st.floats(0.5, 5.0),
)  # fmt: skip
def test_position_and_velocity_stay_within_their_bounds(
    cycles: list[tuple[bool, int]], amplitude: float, frequency: float, fade: float
) -> None:
    """For any switching and any number of skipped cycles; the velocities add up to the position."""
    settings = Dither(True, amplitude, frequency, fade)
    state, position = STILL, 0.0
    for wanted, elapsed in cycles:
        state, velocity = dither_on(state, wanted, elapsed * CYCLE_S, settings)
        position += velocity * elapsed * CYCLE_S
        assert abs(velocity) <= highest_velocity_rad_s(settings) * (1.0 + 1e-9)
        assert abs(state.position_rad) <= amplitude
        assert position == pytest.approx(state.position_rad, abs=1e-9)


def test_faded_in_and_out_it_leaves_the_joint_where_it_was_and_the_arm_still() -> None:
    """Zero mean; and less than a hundredth of its own tip motion is left as vibration."""
    settings = Dither(True)
    model = assumed_model(REGIMES["triggered drift"], 0.3)
    plant = arm_plant(Arm(), LENGTH_M, model.arm.modes[0].participation, model.drive.bandwidth_hz, 2)
    state, positions = STILL, []
    for cycle in range(13_500):
        state, velocity = dither_on(state, cycle < 10_000, CYCLE_S, settings)
        plant.advance(velocity)
        positions.append(state.position_rad)
    assert state == STILL
    assert abs(plant.joint_position_rad) < 1e-9
    assert abs(np.mean(positions[4000:10_000])) < 1e-5
    assert amplitude_m(plant, Arm()) < 0.01 * settings.amplitude_rad * LENGTH_M


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        (Dither(True, frequency_hz=2.4), "frequency_hz = 2.4"),
        (Dither(True, 0.02, 8.0), "amplitude_rad = 0.02"),
    ],
)
def test_a_frequency_near_a_mode_or_too_fast_a_motion_is_refused(settings: Dither, says: str) -> None:
    """In one line that names the key."""
    with pytest.raises(UserError, match=says):
        check_dither(settings, assumed_model(REGIMES["triggered drift"], 0.3))


def run(
    dither: Dither, dies_s: float, damped: bool, duration_s: float = 22.0, moves_rad_s: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[float]]:
    """A triggered, drifting camera; struck every 2.7 s. Frames' delay errors with stated deviations, and times;
    commands."""
    regime, arm = REGIMES["triggered drift"], Arm()
    model, random = assumed_model(regime, 0.3), np.random.default_rng(2718)
    mode, drive = model.arm.modes[0], model.drive
    plant = arm_plant(
        arm, LENGTH_M, mode.participation, drive.bandwidth_hz, round(drive.dead_time_s / CYCLE_S)
    )
    controller = Controller(
        model, Settings(arm_at_start=True, method="fused", dither=dither), "the test's model"
    )
    frames = expose(regime, duration_s, random)
    tips = np.zeros(round(duration_s / CYCLE_S) + 1)
    noise = 0.3 * arm.angular_frequency**2 * arm.amplitude_m
    said: list[tuple[float, float, float]] = []
    commands = []
    next_frame, delays = 0, FrameDelays()
    for cycle in range(len(tips) - 1):
        time_s = cycle * CYCLE_S
        if cycle % 2700 == 10:
            strike(plant, arm, arm.angular_frequency * arm.amplitude_m)
        tips[cycle] = plant.tip_position_m
        samples = []
        while next_frame < len(frames.number) and frames.read_cycle[next_frame] <= cycle:
            at = float(frames.exposed_s[next_frame]) / CYCLE_S
            low = int(at)
            seen = tips[low] + (at - low) * (tips[low + 1] - tips[low])
            seen += arm.vision_noise * arm.amplitude_m * random.standard_normal()
            samples.append(visual_sample(frames, next_frame, float(seen), arm))
            next_frame += 1
        felt = plant.tip_acceleration_m_s2 + noise * random.standard_normal()
        output = controller.step(
            CycleInput(
                cycle, felt if time_s < dies_s else nan, plant.joint_position_rad, plant.joint_velocity_rad_s, 0.0,
                moves_rad_s * float(np.sin(2.0 * np.pi * 0.7 * time_s)), damped, samples,
            )
        )  # fmt: skip
        commands.append(output.command_rad_s)
        said.extend((time_s, nan, nan) for _ in samples)
        for frame, delay in delays.told(samples, output.estimate):
            true_delay = frames.read_cycle[frame] * CYCLE_S - float(frames.exposed_s[frame])
            said[frame] = said[frame][0], delay.delay_s - true_delay, delay.std_s
        plant.advance(output.command_rad_s)
    times, errors, stds = np.array(said).T
    return errors, stds, times, commands


@pytest.mark.slow
def test_a_moving_joint_dates_a_triggered_camera_that_never_had_an_accelerometer() -> None:
    """The image correlated with the known motion: the delay within 1.5 ms rms, and said truly."""
    errors, stds, times, _ = run(Dither(), 0.0, damped=False, duration_s=14.0, moves_rad_s=0.1)
    late = times > 5.0
    assert np.sqrt(np.mean(errors[late] ** 2)) < 0.0015
    assert 0.2 < np.mean((errors[late] / stds[late]) ** 2) < 3.0


@pytest.mark.slow
def test_the_dither_restores_the_delay_after_the_accelerometers_death() -> None:
    """While damping is on; without it the delay drifts away unseen."""
    without = run(Dither(), 5.0, damped=True)
    with_it = run(Dither(True), 5.0, damped=True)
    late = without[2] > 10.0
    lost = np.sqrt(np.mean(without[0][late] ** 2))
    found = np.sqrt(np.mean(with_it[0][late] ** 2))
    assert found < 0.002
    assert found < 0.6 * lost
    assert np.mean((with_it[0][late] / with_it[1][late]) ** 2) < 3.0


@pytest.mark.slow
def test_it_waits_for_the_accelerometers_death_and_for_damping() -> None:
    """Alive, or not damping: not a single command differs."""
    assert (
        run(Dither(True), 99.0, damped=True, duration_s=4.0)[3]
        == run(Dither(), 99.0, damped=True, duration_s=4.0)[3]
    )
    assert not any(run(Dither(True), 1.0, damped=False, duration_s=4.0)[3])
