"""Causes that change no mean: spikes, lost frames, bursts; and silence where there is none of them."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from scipy.signal import lfilter

from stillarm.diagnosis.data.measured import Frames, Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.laws import laws
from tests.fixtures.synthetic import MODEL, NOISE, fitted, measured

SECONDS = 12.0
SPLIT = interleaved(SECONDS)


def found_in(data: Measured) -> dict[str, dict[str, tuple[float, float]]]:
    """Laws found, with their parameters, whose gain is more than chance on both parts."""
    last = fitted(data, split=SPLIT)
    return {
        one.cause: one.values
        for one in laws(make_data(last.world, SPLIT), last)
        if one.held_out_score.sum() > 10.0
    }


def frames_of(data: Measured, keep: np.ndarray, late_s: np.ndarray | float = 0.0) -> Measured:
    """The same data with some frames only, some of them later."""
    f = data.frames
    received = np.maximum.accumulate(f.received_s + late_s)[keep]
    return replace(
        data,
        frames=Frames(
            f.counter[keep], received, f.started_s[keep], f.displacement_px[keep], f.captured_s[keep]
        ),
    )


@pytest.mark.slow
def test_where_there_is_nothing_nothing_is_found() -> None:
    assert found_in(measured(SECONDS, 3)) == {}


def test_spikes_are_counted_and_sized() -> None:
    data = measured(SECONDS, 4)
    random = np.random.default_rng(1)
    spiked = data.acceleration.copy()
    at = random.choice(len(spiked), 60, replace=False)
    spiked[at] += random.choice([-8.0, 8.0], 60)
    found = found_in(replace(data, acceleration=spiked))
    rate, size = found["impulse_noise"]["rate_hz"], found["impulse_noise"]["amplitude_m_s2"]
    assert abs(rate[0] - 5.0) < 3.0 * max(rate[1], 0.1)
    assert abs(size[0] - 8.0) < 0.3


@pytest.mark.slow
def test_few_spikes_are_seen_in_a_quick_motion() -> None:
    data = measured(SECONDS, 4)
    quiet = data.acceleration.copy()
    at = np.array([900, 3500, 5100, 7700, 9100, 11050])
    quiet[at] += 12.0 * NOISE["acceleration"]
    assert len(found_in(replace(data, acceleration=quiet))) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "beside", "seen"), [(40.0, 0.0, True), (40.0, 25.0, True), (12.0, 0.0, False)]
)
def test_a_single_spike_counts_where_no_noise_goes_so_far(size: float, beside: float, seen: bool) -> None:
    """Of one sample, or of two."""
    data = measured(SECONDS, 4)
    spiked = data.acceleration.copy()
    spiked[9100] += size * NOISE["acceleration"]
    spiked[9101] += beside * NOISE["acceleration"]
    last = fitted(replace(data, acceleration=spiked), split=SPLIT)
    found = [one for one in laws(make_data(last.world, SPLIT), last) if one.cause == "impulse_noise"]
    assert len(found) == seen
    for one in found:
        assert one.held_out_score.sum() > 3.0
        assert one.values["rate_hz"] == pytest.approx((1.0 / SECONDS, 1.0 / SECONDS), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("size", [30.0, 12.0])
def test_two_spikes_close_together_are_counted(size: float) -> None:
    """No other block shows any."""
    data = measured(SECONDS, 4)
    spiked = data.acceleration.copy()
    spiked[[9100, 9150]] += np.array([size, -11.0]) * NOISE["acceleration"]
    last = fitted(replace(data, acceleration=spiked), split=SPLIT)
    (law,) = (one for one in laws(make_data(last.world, SPLIT), last) if one.cause == "impulse_noise")
    assert law.values["rate_hz"][0] == pytest.approx(2.0 / SECONDS, rel=0.05)


def test_lost_frames_are_counted() -> None:
    data = measured(SECONDS, 5)
    keep = np.random.default_rng(2).random(len(data.frames)) > 0.1
    keep[:3] = keep[-3:] = True
    fraction, std = found_in(frames_of(data, keep))["frame_drops"]["fraction"]
    assert abs(fraction - (1.0 - keep.mean())) < 3.0 * std


@pytest.mark.slow
def test_bursts_are_counted_and_timed() -> None:
    data = measured(SECONDS, 6)
    received = data.frames.received_s
    late = np.zeros(len(received))
    for start in (1.0, 3.1, 4.0, 6.2, 8.3, 10.4):
        late[(received >= start) & (received < start + 0.4)] = 0.08
    found = found_in(frames_of(data, np.ones(len(received), bool), late))["delay_bursts"]
    assert abs(found["rate_hz"][0] - 0.5) < 0.1
    assert abs(found["delay_s"][0] - 0.08) < 0.008
    assert abs(found["duration_s"][0] - 0.4) < 0.08


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stated_s", "lasts_s", "burst"), [(0.0005, 0.03, True), (0.0064, 0.03, False), (0.0064, 0.2, True)]
)
def test_a_few_late_frames_within_the_delays_stated_spread_are_no_burst(
    stated_s: float, lasts_s: float, burst: bool
) -> None:
    model = msgspec.structs.replace(
        MODEL, timing=msgspec.structs.replace(MODEL.timing, capture_delay_std_s=stated_s)
    )
    data = measured(SECONDS, 6)
    received = data.frames.received_s
    late = np.where(received % 0.7 < lasts_s, 0.009, 0.0)
    last = fitted(frames_of(data, np.ones(len(received), bool), late), split=SPLIT, model=model)
    names = [one.cause for one in laws(make_data(last.world, SPLIT), last)]
    assert ("delay_bursts" in names) is burst


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_what_most_frames_do_is_no_burst(seed: int) -> None:
    """Frames that scatter but for stretches in which they hardly do were not late before."""
    data = measured(SECONDS, 6)
    received = data.frames.received_s
    random = np.random.default_rng(seed)
    wander = lfilter([0.003], [1.0, -0.97], random.standard_normal(len(received)))
    late = np.where(received % 4.0 < 3.2, wander + random.normal(0.0, 0.006, len(received)), 0.0)
    last = fitted(frames_of(data, np.ones(len(received), bool), 0.03 + late), split=SPLIT)
    assert "delay_bursts" not in [one.cause for one in laws(make_data(last.world, SPLIT), last)]


@pytest.mark.slow
def test_what_the_start_and_an_impact_leave_for_an_instant_are_no_spikes() -> None:
    struck = (3300, 9000)
    for begun, count in ((0, 0), (60, 1)):
        data = measured(SECONDS, 4, {"jump.1.0.v": 0.3, "jump.2.0.v": -0.3}, impacts=struck)
        shown = data.acceleration.copy()
        shown[[begun + 1, *(cycle + begun + 4 for cycle in struck)]] += 20.0 * NOISE["acceleration"]
        world = World(replace(data, acceleration=shown), MODEL, struck)
        last = fit(make_data(world, SPLIT), world.space.vector(), world.baseline_names())
        assert sum(one.cause == "impulse_noise" for one in laws(make_data(world, SPLIT), last)) == count


def test_bursts_are_sought_again_only_where_images_come_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    last = fitted(measured(20.0, 1))
    data, sought = make_data(last.world, SPLIT), []
    monkeypatch.setattr("stillarm.diagnosis.sensors.laws._delay_bursts", lambda *given: sought.append(given))
    laws(data, last)
    laws(data, last, (last, []))
    shown = {**last.predicted.channels, "arrival": last.predicted.channels["arrival"] + 0.01}
    laws(data, replace(last, predicted=replace(last.predicted, channels=shown)), (last, []))
    assert len(sought) == 1
    shown["arrival"] = shown["arrival"] + 0.01 * np.sin(np.arange(len(shown["arrival"])))
    laws(data, replace(last, predicted=replace(last.predicted, channels=shown)), (last, []))
    assert len(sought) == 2
