"""The fused method against trials drawn apart from it: accuracy, calibration, faults. Errors are of the amplitude."""

from collections.abc import Callable
from math import nan

import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Mode
from stillarm.controller.estimation.estimate import Status
from stillarm.controller.estimation.fused.filters.laws import Law
from stillarm.controller.estimation.fused.method import FusedMethod
from stillarm.controller.estimation.methods import make_method
from tests.reference.ringing_world import Trial, judge, model_for, ring

AMPLITUDE = 0.006


def run(
    duration_s: float, seed: int, *, change: Callable[[int, float], float] = lambda k, a: a, mode: str = "freerun",
    modes: list[Mode] | None = None, **world: object,
) -> tuple[Trial, FusedMethod]:  # fmt: skip
    model = model_for(AMPLITUDE, 0.3, mode=mode, modes=modes)
    world.setdefault("excitation", "steady")
    trial = ring(model, seed, duration_s, triggered=mode == "triggered", **world)  # type: ignore[arg-type]
    method = make_method("fused", model, Settings(), "model")
    assert isinstance(method, FusedMethod)
    return judge(method, model, trial, change), method


def part(trial: Trial, from_s: float, to_s: float) -> tuple[float, float, float]:
    """Mean and largest absolute error, and normalised error squared, over a part."""
    here = slice(round(from_s * 1000), round(to_s * 1000))
    error = np.abs(trial.error[here])
    return float(error.mean()), float(error.max()), float(np.mean(trial.ratio[here] ** 2))


@pytest.mark.slow
@pytest.mark.parametrize("delay", ["drift", "white"])
def test_a_free_running_camera_is_dated_by_its_clock(delay: str) -> None:
    """Whatever the operating system adds to the arrival, and with a rate up to 100 ppm off."""
    trial, method = run(9.0, 1, delay=delay)
    mean, largest, ratio = part(trial, 2.0, 9.0)
    assert mean < 0.012
    assert largest < 0.04
    assert 0.2 < ratio < 2.5
    assert method.frames.evidence.law(Law.CLOCK) > 0.9
    late = trial.delay_time > 2.0
    assert np.sqrt(np.mean(trial.delay_error[late] ** 2)) < 0.0011


@pytest.mark.slow
def test_irregular_exposures_with_a_delay_of_their_own_are_dated_one_by_one() -> None:
    """No clock, white jitter of 6.4 ms: each frame's own instant, better than the jitter, and as well as it is said."""
    trial, method = run(9.0, 2, mode="triggered", delay="white")
    mean, largest, ratio = part(trial, 2.0, 9.0)
    assert mean < 0.025
    assert largest < 0.1
    assert 0.2 < ratio < 2.5
    assert method.frames.evidence.law(Law.CLOCK) < 0.05
    late = trial.delay_time > 2.0
    assert np.sqrt(np.mean(trial.delay_error[late] ** 2)) < 0.0045
    assert 0.3 < np.mean((trial.delay_error[late] / trial.delay_std[late]) ** 2) < 2.5


@pytest.mark.slow
def test_a_camera_set_up_as_free_running_that_is_triggered_is_found_out() -> None:
    """The images refute the clock, whatever the model file says."""
    model = model_for(AMPLITUDE, 0.3, mode="freerun")
    trial = ring(model, 3, 6.0, triggered=True, delay="constant", excitation="steady")
    method = FusedMethod(model, Settings().fused, "model")
    said = judge(method, model, trial)
    assert method.frames.evidence.law(Law.CLOCK) < 0.05
    assert part(said, 3.0, 6.0)[0] < 0.02


@pytest.mark.slow
def test_stamps_on_a_clock_of_their_own_are_used() -> None:
    """Irregular exposures with stamps, offset and rate unknown: as good as a clock."""
    trial, method = run(8.0, 4, mode="triggered", delay="white", stamped=True)
    assert method.frames.evidence.law(Law.STAMPS) > 0.9
    assert part(trial, 3.0, 8.0)[0] < 0.012


@pytest.mark.slow
def test_after_an_impact_the_deflection_is_soon_right_again() -> None:
    """An impact of half the amplitude: within 4 percent 0.2 s after it, as told by images that are 74 ms late."""
    trial, _ = run(9.0, 5, delay="white", excitation="strikes")
    model = model_for(AMPLITUDE, 0.3)
    envelope = ring(model, 5, 9.0, delay="white", excitation="strikes").envelope
    impacts = np.flatnonzero(np.diff(envelope) > 0.15 * AMPLITUDE)
    impacts = impacts[(impacts > 2000) & (impacts < 8500)]
    assert len(impacts) >= 1
    for impact in impacts:
        assert np.max(np.abs(trial.error[impact + 200 : impact + 450])) < 0.04


@pytest.mark.slow
def test_n_i_keeps_time_when_the_accelerometer_is_dead() -> None:
    """Arrivals that wander tell no clock's rate: n_i does, and the delay stays within what is stated."""
    stds = []
    for follows in (False, True):
        trial, method = run(
            22.0, 8, delay="drift", started_ahead=(lambda t: 0.01) if follows else None,
            change=lambda k, a: a if k < 10000 else nan,
        )  # fmt: skip
        late = trial.delay_time > 12.0
        assert np.mean((trial.delay_error[late] / trial.delay_std[late]) ** 2) < 4.0
        bank, at = method.frames.bank, method.frames.evidence.best
        stds.append(bank.p[at, method._at.skew, method._at.skew] ** 0.5)
    assert stds[1] < 0.7 * stds[0]


@pytest.mark.slow
def test_an_n_i_that_jumps_is_not_followed() -> None:
    """By two frames at 8 s, and back again at 12 s."""
    trial, _ = run(16.0, 9, delay="drift", started_ahead=lambda t: 0.01 if not 8.0 < t < 12.0 else 0.041)
    late = trial.delay_time > 5.0
    assert np.sqrt(np.mean(trial.delay_error[late] ** 2)) < 0.0011
    assert part(trial, 5.0, 16.0)[0] < 0.012


@pytest.mark.slow
def test_after_the_accelerometers_death_the_clock_goes_on() -> None:
    """Missing samples from 6 s on."""
    trial, method = run(14.0, 6, delay="white", change=lambda k, a: a if k < 6000 else nan)
    assert part(trial, 6.0, 14.0)[0] < 0.015
    assert method.reason == "accelerometer silent"


@pytest.mark.slow
@pytest.mark.parametrize(
    "dead", [lambda k, noise: 0.3, lambda k, noise: float(0.5 * noise[k])], ids=["stuck", "noise"]
)
def test_a_sensor_that_no_longer_shows_the_vibration_is_muted(
    dead: Callable[[int, np.ndarray], float],
) -> None:
    """Stuck at a value, or nothing but noise: recognised, and after a second no harm is left."""
    noise = np.random.default_rng(0).standard_normal(10_000)
    trial, method = run(10.0, 7, delay="white", change=lambda k, a: a if k < 6000 else dead(k, noise))
    assert part(trial, 7.5, 10.0)[0] < 0.015
    assert method.reason.startswith("accelerometer")


@pytest.mark.slow
def test_an_accelerometer_whose_gain_falls_is_told_of() -> None:
    """By a quarter within 10 s: to these two sensors no other thing than a scene that comes nearer."""
    _, method = run(6.0, 10, delay="white")
    assert method.reason == ""
    _, method = run(16.0, 10, delay="white", change=lambda k, a: a * (1.0 - 2.5e-5 * max(0, k - 6000)))
    assert method.reason.startswith("images and accelerometer drift apart")


@pytest.mark.slow
def test_spikes_and_sudden_noise_do_little() -> None:
    """Two percent of the samples off by 20 m/s^2; then noise ten times as large."""
    noise = np.random.default_rng(1).standard_normal((10_000, 2))

    def change(k: int, a: float) -> float:
        if k < 6000:
            return a + 20.0 * float(noise[k, 0]) if abs(noise[k, 1]) > 2.33 else a
        return a + 5.0 * float(noise[k, 0])

    trial, _ = run(9.0, 8, delay="white", change=change)
    assert part(trial, 2.0, 6.0)[0] < 0.015
    assert part(trial, 6.0, 9.0)[0] < 0.015


@pytest.mark.slow
@pytest.mark.parametrize(
    "world",
    [
        {"frequency": lambda t: 1.02},
        {"scale_factor": lambda t: 1.2},
        {"lost": 0.1},
        {"command": lambda t: 0.1 * np.sin(2 * np.pi * 0.3 * t)},
    ],
    ids=["frequency 2 % off", "depth 20 % off", "frames lost", "joint moves"],
)
def test_what_the_model_does_not_say_is_found(world: dict[str, object]) -> None:
    """Each departure alone costs little once it is learnt."""
    trial, _ = run(9.0, 9, delay="white", **world)
    mean, _, ratio = part(trial, 4.0, 9.0)
    assert mean < 0.015
    assert ratio < 3.0


@pytest.mark.slow
def test_a_payload_taken_up_in_mid_run_is_followed() -> None:
    """Frequency 9 percent lower from 4 s on: a fifth more mass."""
    trial, _ = run(11.0, 10, delay="white", frequency=lambda t: 1.0 if t < 4.0 else 0.913)
    assert part(trial, 8.0, 11.0)[0] < 0.015


@pytest.mark.slow
def test_frames_lost_from_a_count_of_arrivals_are_noticed() -> None:
    """The counter goes on by one although two frames never came."""
    model = model_for(AMPLITUDE, 0.3)
    trial = ring(model, 11, 9.0, delay="constant", excitation="steady")
    gone = [c for c, samples in sorted(trial.samples.items()) if samples[0].frame in (300, 301)]
    for cycle in gone:
        del trial.samples[cycle]
    for samples in trial.samples.values():
        samples[:] = [
            type(s)(s.frame - 2 if s.frame > 301 else s.frame, s.started_cycle, s.status, s.displacement_x_px)
            for s in samples
        ]
    said = judge(FusedMethod(model, Settings().fused, "model"), model, trial)
    assert part(said, 5.5, 9.0)[0] < 0.015
    late = said.delay_time > 5.5
    assert np.max(np.abs(said.delay_error[late])) < 0.004


@pytest.mark.slow
def test_duplicates_a_reset_counter_and_missing_numbers_do_no_harm() -> None:
    """Every tenth frame twice, a counter that starts again at zero, a NaN that claims to be measured."""
    model = model_for(AMPLITUDE, 0.3)
    trial = ring(model, 12, 8.0, delay="white", excitation="steady")
    for samples in trial.samples.values():
        s = samples[0]
        number = s.frame if s.frame < 250 else s.frame - 250
        value = nan if s.frame % 37 == 5 else s.displacement_x_px
        samples[:] = [type(s)(number, s.started_cycle, s.status, value)] * (2 if s.frame % 10 == 0 else 1)
    said = judge(FusedMethod(model, Settings().fused, "model"), model, trial)
    assert np.all(np.isfinite(said.error))
    assert part(said, 2.0, 3.8)[0] < 0.015
    assert part(said, 6.0, 8.0)[0] < 0.02


def test_at_rest_the_delay_is_unestimated_and_nothing_is_claimed() -> None:
    """Before the first impact: the prior delay, with its spread; the deflection within its deviation."""
    trial, _ = run(3.0, 13, rest_s=60.0, offset_px=30.0)
    assert set(trial.status) <= {Status.UNESTIMATED.value, Status.HELD.value}
    assert np.all(trial.delay_std > 0.004)
    assert part(trial, 1.0, 3.0)[2] < 4.0


@pytest.mark.slow
def test_two_modes_are_told_apart() -> None:
    """The sum of both, as the tip moves, is predicted while both ring."""
    modes = [Mode(participation=1.1), Mode(frequency_hz=14.0, damping_ratio=0.003, participation=-0.3)]
    trial, _ = run(6.0, 14, modes=modes, excitation="once", delay="constant")
    assert part(trial, 2.5, 5.0)[0] < 0.03


def test_the_same_numbers_give_the_same_answers() -> None:
    """Replay must repeat, to the bit."""
    first, _ = run(1.5, 15, delay="white")
    second, _ = run(1.5, 15, delay="white")
    assert np.array_equal(first.error, second.error, equal_nan=True)
    assert np.array_equal(first.delay_std, second.delay_std)
