"""Every effect of the hidden world touches what it should, leaves alone what it should, and looks as it is named."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stillarm.common.csv_bundle.bundle_import import import_bundle
from tests.hidden_world.bundle import write_bundle
from tests.hidden_world.draw import departure_of, draw_case, sized
from tests.hidden_world.effects import CAUSES, UNKNOWN, Effect
from tests.hidden_world.rig import TICK_S
from tests.hidden_world.whitened import by_channel
from tests.hidden_world.world import Case, Open, make, run

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
SECONDS = 9.0
TOUCHED = {
    "arm": {"acceleration", "image"},
    "drive": {"acceleration", "angle", "speed", "image"},
    "accelerometer": {"acceleration"},
    "camera": {"image"},
    "timing": {"image", "arrival", "stamp"},
}
AT_A_LIMIT = {"drive_saturation", "accelerometer_clipping"}
NO_MEAN = {"impulse_noise", "frame_drops"}


def clear_case(seed: int, name: str, size: float) -> Case:
    at_a_limit = name in AT_A_LIMIT  # nothing shows before a fast move reaches it
    return draw_case(seed, name, 1.0 if at_a_limit else size, 25.0 if at_a_limit else SECONDS)


def with_size(
    name: str, departure: float, seed: int = 5, plain: bool = False, **values: float
) -> tuple[Case, Effect]:
    case = draw_case(seed, name, 0.8, SECONDS)
    effect = case.effects[0].plain if plain else case.effects[0]
    effect = sized(effect, case.rig, departure)
    effect = replace(effect, values={**effect.values, **values})
    return replace(case, damped=False, effects=(effect,)), effect


@pytest.mark.parametrize("name", [*CAUSES, *UNKNOWN])
def test_an_effect_touches_its_own_channels_and_no_other(name: str) -> None:
    case = replace(clear_case(11, name, 0.7), damped=False)
    with_it = run(case)
    without = replace(case, effects=())
    there, bare = by_channel(case, with_it), by_channel(without, run(without, Open(command=with_it.command)))
    moved = {channel for channel in there if np.max(np.abs(there[channel] - bare[channel])) > 1e-6}
    if name in NO_MEAN:
        assert not moved
    elif name in CAUSES:
        assert moved and moved <= TOUCHED[CAUSES[name].where], moved
    else:
        assert moved


@pytest.mark.parametrize("name", sorted(CAUSES))
def test_a_size_reads_back_and_the_rough_form_lies_near_the_plain_one(name: str) -> None:
    case = replace(clear_case(7, name, 0.6), damped=False)
    effect = case.effects[0]
    assert sized(effect, case.rig, departure_of(effect, case.rig)).values == pytest.approx(effect.values)
    if name in NO_MEAN | {"delay_bursts", "clock_step", "stale_frame_buffer"}:
        return
    with_plain, with_none = replace(case, effects=(effect.plain,)), replace(case, effects=())
    plain, rough, bare = (by_channel(c, run(c)) for c in (with_plain, case, with_none))
    whole = sum(float(np.sum((plain[c] - bare[c]) ** 2)) for c in plain)
    apart = sum(float(np.sum((plain[c] - rough[c]) ** 2)) for c in plain)
    assert 0.0 < apart < 0.6 * whole, (apart, whole)


def test_the_same_seed_gives_the_same_recording_and_another_another() -> None:
    first, again, other = (make(draw_case(seed, "gusts", 0.5, 4.0)) for seed in (3, 3, 4))
    for name in ("time", "acceleration", "image", "received", "angle"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
    assert not np.array_equal(first.acceleration, other.acceleration)


def test_the_noise_is_that_of_the_rig() -> None:
    case = draw_case(8, None, None, 20.0)
    recording, rig = make(case), case.rig
    rest = recording.acceleration - recording.truth["acceleration"]
    assert np.std(rest) == pytest.approx(np.hypot(rig.feeler.hiss, rig.feeler.grain / 12**0.5), rel=0.03)
    assert np.std(recording.image - recording.truth["image"]) == pytest.approx(rig.eye.px_noise, rel=0.1)
    late = recording.received - recording.truth["middle_s"]
    assert np.mean(late) == pytest.approx(rig.eye.late_s, abs=3.0 * rig.eye.late_spread_s)
    assert np.all(np.diff(recording.received) > 0.5 * TICK_S)
    assert recording.received == pytest.approx(np.round(recording.received / TICK_S) * TICK_S, abs=1e-9)
    assert np.all(recording.started < recording.received)


def test_mains_hum_is_a_line_at_its_frequency() -> None:
    case, effect = with_size("mains_hum", 1.0, frequency_hz=50.0)
    plain = make(replace(case, effects=())).acceleration
    spectrum = np.abs(np.fft.rfft(make(case).acceleration - plain))
    assert np.argmax(spectrum) * (1.0 / SECONDS) == pytest.approx(50.0, abs=0.15)
    assert effect["amplitude_m_s2"] == 1.0


def test_clipping_bounds_the_reading() -> None:
    case, effect = with_size("accelerometer_clipping", 0.9)
    recording = make(case)
    assert np.max(np.abs(recording.acceleration)) <= effect["range_m_s2"] + case.rig.feeler.grain
    assert np.max(np.abs(make(replace(case, effects=())).acceleration)) > effect["range_m_s2"]


def test_impulses_come_at_their_rate_and_size() -> None:
    case, _ = with_size("impulse_noise", 10.0, amplitude_m_s2=5.0)
    rest = make(case).acceleration - make(replace(case, effects=())).acceleration
    hits = np.abs(rest) > 1.0
    assert 50 < np.sum(hits) < 170
    assert np.median(np.abs(rest[hits])) == pytest.approx(5.0, rel=0.3)


def test_skewed_frames_are_further_apart() -> None:
    case, _ = with_size("camera_clock_skew", 1000.0, plain=True)
    step = np.diff(run(case).frames.middle)
    assert step == pytest.approx(1.001 / case.rig.eye.rate, rel=1e-9)


def test_lost_frames_are_a_gap_or_none_in_the_count() -> None:
    case, _ = with_size("frame_drops", 0.2)
    for counts_exposures in (True, False):
        eye = replace(case.rig.eye, counts_exposures=counts_exposures)
        recording = make(replace(case, rig=replace(case.rig, eye=eye)))
        lost = 1.0 - len(recording.number) / (recording.truth["middle_s"][-1] * case.rig.eye.rate)
        assert 0.05 < lost < 0.4
        assert bool(np.all(np.diff(recording.number) == 1)) is not counts_exposures


def test_a_stale_buffer_shows_what_was_a_frame_ago() -> None:
    case, effect = with_size("stale_frame_buffer", 2.0)
    for counts_exposures in (True, False):
        eye = replace(case.rig.eye, counts_exposures=counts_exposures)
        own = replace(case, rig=replace(case.rig, eye=eye))
        stale, fresh = run(own).frames, run(replace(own, effects=())).frames
        late = (stale.arrival - stale.middle) - (fresh.arrival - fresh.middle)
        after = stale.arrival > effect["onset_s"] + 0.3
        assert np.mean(late[after]) == pytest.approx(2.0 / eye.rate, abs=0.002)
        assert np.max(np.abs(late[stale.arrival < effect["onset_s"] - 0.3])) < 1e-9


@pytest.mark.parametrize("kind", ["frames", "all", "stamp"])
def test_a_clock_steps_where_its_kind_says(kind: str) -> None:
    case, effect = with_size("clock_step", 0.1)
    eye = replace(case.rig.eye, stamped=True, free=True)
    case = replace(case, rig=replace(case.rig, eye=eye), effects=(replace(effect, kind=kind),))
    stepped, steady = make(case), make(replace(case, effects=()))
    moved = {
        "time": stepped.time[-1] - steady.time[-1],
        "received": stepped.received[-1] - steady.received[-1],
        "started": stepped.started[-1] - steady.started[-1],
        "stamp": stepped.stamp[-1] - steady.stamp[-1],
    }
    expected = {
        "frames": {"received", "started"},
        "all": {"time", "received", "started"},
        "stamp": {"stamp"},
    }[kind]
    for name, by in moved.items():
        assert by == pytest.approx(0.1 if name in expected else 0.0, abs=1e-9), name


def test_a_payload_lowers_the_frequency_after_its_onset_only() -> None:
    case, effect = with_size("payload_change", -0.1, onset_s=4.0)
    with_it, without = run(case), run(replace(case, effects=()))
    before = slice(0, 3990)
    assert np.array_equal(with_it.acceleration[before], without.acceleration[before])
    assert np.max(np.abs(with_it.gauge[4200:] - without.gauge[4200:])) > 1e-3
    assert effect["frequency_ratio"] == pytest.approx(0.9)


def test_a_bundle_has_the_same_columns_whatever_it_hides_and_says_nothing(tmp_path: Path) -> None:
    heads = set()
    for place, name in enumerate([None, "frame_drops", "loose_mount", "clock_step"]):
        folder = tmp_path / f"d{place}"
        write_bundle(make(draw_case(20 + place, name, 0.7, 3.0)), folder)
        assert sorted(path.name for path in folder.iterdir()) == ["fast.csv", "frames.csv", "model.toml"]
        heads.add(tuple((folder / f).read_text().split("\n", 1)[0] for f in ("fast.csv", "frames.csv")))
        everything = " ".join((folder / f).read_text() for f in ("fast.csv", "frames.csv", "model.toml"))
        assert not [word for word in (*CAUSES, *UNKNOWN, "effect", "cause", "seed") if word in everything]
    assert len(heads) == 1


def test_the_program_imports_a_bundle(tmp_path: Path) -> None:
    write_bundle(make(draw_case(2, "frame_drops", 0.7, 3.0)), tmp_path / "data")
    import_bundle(tmp_path / "data", tmp_path / "rec.mcap")
    assert (tmp_path / "rec.mcap").stat().st_size > 10_000


def test_channels_that_are_not_kept_are_empty(tmp_path: Path) -> None:
    write_bundle(make(draw_case(2, None, None, 2.0, frozenset({"acceleration"}))), tmp_path)
    assert not (tmp_path / "frames.csv").exists()
    rows = [line.split(",") for line in (tmp_path / "fast.csv").read_text().splitlines()]
    filled = {rows[0][k] for k in range(len(rows[0])) if rows[5][k]}
    assert filled == {"time_s", "acceleration_m_s2"}
