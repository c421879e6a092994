"""The camera's instants: the grid of exposures, the order of handovers, the delay's mean and spread."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Rig, SimulatedScene
from stillarm.common.files.model import Camera, Timing
from stillarm.common.user_error import UserError
from stillarm.simulation.camera.camera_timing import TRANSFER_S, CameraTiming, Exposure

AFTER = 0.004


def _run(timing: CameraTiming, frames: int) -> list[Exposure]:
    return [timing.expose() for _ in range(frames)]


def _delays(exposures: list[Exposure]) -> np.ndarray:
    return np.array([e.handover_s - e.mid_s for e in exposures]) + AFTER


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fraction", "mean_s", "std_s"),
    [
        (0.9, 0.074, 0.0064),
        (0.0, 0.074, 0.0064),  # order binds one frame in twenty
        (0.0, 0.074, 0.015),  # order binds nearly half of them
        (0.5, 0.024, 0.0064),  # the read-out binds
    ],
)
def test_mean_and_spread_of_the_capture_delay_hold_over_a_long_run(
    fraction: float, mean_s: float, std_s: float
) -> None:
    # A short wander makes a long run of 60000 frames: at 2 s the mean of so many still strays by 0.3 ms.
    rig = Rig(delay_wander_fraction=fraction, delay_wander_time_s=0.2)
    asked = Timing(capture_delay_s=mean_s, capture_delay_std_s=std_s)
    delays = _delays(_run(CameraTiming(Camera(), asked, rig, 3, after_delivery_s=AFTER), 60_000))
    assert delays.mean() == pytest.approx(mean_s, rel=0.02)
    assert delays.std() == pytest.approx(std_s, rel=0.05)


def test_without_the_correction_order_would_bias_the_delay() -> None:
    # Guards the test above: what is corrected there is larger than its tolerance.
    rng = np.random.default_rng(0)
    free = 0.070 + 0.015 * rng.standard_normal(60_000)
    slack = (1.0 / 65.0 - TRANSFER_S) * np.arange(len(free))
    ordered = np.maximum.accumulate(free + slack) - slack
    assert ordered.mean() - free.mean() > 0.02 * 0.074


@pytest.mark.slow
def test_wander_is_slow_and_has_its_share_of_the_variance() -> None:
    rig = Rig(delay_wander_fraction=0.8, delay_wander_time_s=0.5)
    delays = _delays(_run(CameraTiming(Camera(), Timing(), rig, 5), 60_000))
    centred = delays - delays.mean()
    lag = 16  # frames
    correlation = float(np.mean(centred[lag:] * centred[:-lag]) / np.mean(centred**2))
    assert correlation == pytest.approx(0.8 * np.exp(-lag / 65.0 / 0.5), abs=0.05)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    fraction=st.floats(0.0, 1.0),
    std_s=st.floats(0.0, 0.012),
    shutter=st.sampled_from(["global", "rolling"]),
    readout_s=st.floats(0.0, 0.012),
)
def test_freerun_keeps_its_grid_its_order_and_its_bounds(
    seed: int, fraction: float, std_s: float, shutter: str, readout_s: float
) -> None:
    camera = Camera(shutter=shutter, readout_s=readout_s)  # type: ignore[arg-type]
    timing = Timing(capture_delay_std_s=std_s)
    rig = Rig(delay_wander_fraction=fraction)
    exposures = _run(CameraTiming(camera, timing, rig, seed, origin_s=100.0), 300)
    starts = np.array([e.start_s for e in exposures])
    assert [e.frame for e in exposures] == list(range(300))
    assert 100.0 <= starts[0] <= 100.0 + 1.0 / 65.0
    np.testing.assert_allclose(starts, starts[0] + np.arange(300) / 65.0, atol=1e-9)
    handovers = np.array([e.handover_s for e in exposures])
    assert np.all(np.diff(handovers) >= TRANSFER_S - 1e-9)
    middle = 0.5 * readout_s if shutter == "rolling" else 0.0
    for e in exposures:
        assert e.mid_s - e.start_s == pytest.approx(0.0075 + middle, abs=1e-9)
        assert e.readout_end_s - e.start_s == pytest.approx(0.015 + readout_s, abs=1e-9)
        assert e.handover_s >= e.readout_end_s + TRANSFER_S - 1e-9


def test_the_seed_decides_everything() -> None:
    first, again, other = (_run(CameraTiming(Camera(), Timing(), Rig(), seed), 50) for seed in (7, 7, 8))
    assert first == again
    assert first != other


def test_a_triggered_camera_exposes_on_request_but_no_faster_than_its_frame_rate() -> None:
    timing = CameraTiming(Camera(mode="triggered"), Timing(), Rig(delay_wander_fraction=0.3), 1)
    first = timing.request(5.0)
    soon = timing.request(5.001)
    later = timing.request(5.5)
    assert first.start_s == 5.0
    assert soon.start_s == pytest.approx(5.0 + 1.0 / 65.0)
    assert later.start_s == 5.5
    now, delays = 6.0, []
    for _ in range(40_000):
        exposure = timing.request(now)
        delays.append(exposure.handover_s - exposure.mid_s + AFTER)
        now = exposure.handover_s + 0.003
    assert np.mean(delays) == pytest.approx(0.074, rel=0.02)
    assert np.std(delays) == pytest.approx(0.0064, rel=0.05)
    with pytest.raises(ValueError, match="triggered"):
        timing.expose()
    with pytest.raises(ValueError, match="freerun"):
        CameraTiming(Camera(), Timing(), Rig(), 1).request(0.0)


def test_stamps_run_on_a_clock_of_their_own() -> None:
    rig = Rig(scene=SimulatedScene(stamped=True))
    exposures = _run(CameraTiming(Camera(), Timing(), rig, 4), 5000)
    mids = np.array([e.mid_s for e in exposures])
    stamps = np.array([e.stamp_s for e in exposures], dtype=float)
    rate, offset = np.polyfit(mids, stamps, 1)
    assert 0.0 < abs(rate - 1.0) <= 51e-6
    assert abs(offset) > 1.0
    np.testing.assert_allclose(
        stamps, rate * mids + offset, atol=1e-6
    )  # the stamp knows nothing of the handover
    unstamped = _run(CameraTiming(Camera(), Timing(), Rig(), 4), 5000)
    assert all(e.stamp_s is None for e in unstamped)
    assert [e.handover_s for e in unstamped] == [e.handover_s for e in exposures]


@pytest.mark.parametrize(
    ("timing", "key"),
    [
        (Timing(capture_delay_s=0.012), "timing.capture_delay_s = 0.012"),
        (Timing(capture_delay_s=0.0126, capture_delay_std_s=0.02), "timing.capture_delay_std_s = 0.02"),
    ],
)
def test_a_delay_that_no_handover_can_give_is_refused_in_one_line(timing: Timing, key: str) -> None:
    with pytest.raises(UserError) as raised:
        CameraTiming(Camera(), timing, Rig(), 0)
    assert str(raised.value).startswith(key)
    assert "\n" not in str(raised.value)


def test_no_spread_means_no_spread() -> None:
    delays = _delays(_run(CameraTiming(Camera(), Timing(capture_delay_std_s=0.0), Rig(), 2), 100))
    np.testing.assert_allclose(delays, 0.074, atol=1e-9)
