"""The timing's causes, frame by frame, against the catalogue's rules; the other chances stay as they were."""

from typing import Any

import numpy as np
import pytest

from stillarm.common.files.configuration import Rig, SimulatedScene
from stillarm.common.files.model import Camera, Model, Timing
from stillarm.simulation.arm.effect_clock import EffectClock
from stillarm.simulation.camera.camera_timing import TRANSFER_S, CameraTiming, Exposure
from stillarm.simulation.camera.frame_timing_effects import FrameTimingEffects

ORIGIN_S = 5.0


def exposures(
    *effects: dict[str, Any], frames: int = 2000, seed: int = 3, std_s: float = 0.0064, stamped: bool = False
) -> list[Exposure]:
    model = Model(timing=Timing(capture_delay_std_s=std_s), effects=list(effects))
    rig = Rig(scene=SimulatedScene(stamped=stamped))
    clock = EffectClock(ORIGIN_S)
    timing = CameraTiming(
        Camera(), model.timing, rig, seed, origin_s=ORIGIN_S, effects=FrameTimingEffects(model, seed, clock)
    )
    return [timing.expose() for _ in range(frames)]


def column(rows: list[Exposure], name: str) -> np.ndarray:
    return np.array([getattr(row, name) for row in rows], dtype=float)


def test_skew_stretches_the_frame_period_and_nothing_else() -> None:
    plain, skewed = (
        exposures(std_s=0.0),
        exposures({"cause": "camera_clock_skew", "skew_ppm": 500.0}, std_s=0.0),
    )
    assert np.diff(column(skewed, "start_s")) == pytest.approx(1.0005 / 65.0, abs=1e-12)
    delays = [column(rows, "handover_s") - column(rows, "mid_s") for rows in (plain, skewed)]
    assert delays[0] == pytest.approx(delays[1], abs=1e-9)


def test_drops_take_their_share_independently_and_the_counter_goes_on() -> None:
    rows = exposures({"cause": "frame_drops", "fraction": 0.2}, frames=20_000)
    lost = column(rows, "lost")
    assert [row.frame for row in rows] == list(range(20_000))
    assert np.mean(lost) == pytest.approx(0.2, abs=4.0 * (0.16 / 20_000) ** 0.5)
    assert abs(np.corrcoef(lost[1:], lost[:-1])[0, 1]) < 0.03
    assert [row._replace(lost=False) for row in rows] == exposures(frames=20_000)


def test_drift_adds_to_the_delay_evenly_from_the_start() -> None:
    plain, drifting = exposures(), exposures({"cause": "delay_drift", "rate_s_per_s": 5e-4})
    later = column(drifting, "handover_s") - column(plain, "handover_s")
    wanted = 5e-4 * (column(plain, "mid_s") - ORIGIN_S)
    free = np.diff(column(plain, "handover_s")) > 2.0 * TRANSFER_S
    assert np.mean(free) > 0.95
    assert later[1:][free] == pytest.approx(wanted[1:][free], abs=1e-12)


@pytest.mark.slow
def test_bursts_come_at_their_rate_last_their_time_and_keep_the_order() -> None:
    effect = {"cause": "delay_bursts", "rate_hz": 0.2, "duration_s": 0.5, "delay_s": 0.06}
    frames = 130_000  # 2000 s
    plain, late = exposures(frames=frames, std_s=0.0), exposures(effect, frames=frames, std_s=0.0)
    more = column(late, "handover_s") - column(plain, "handover_s")
    assert np.all(np.diff(column(late, "handover_s")) >= TRANSFER_S - 1e-9)
    held = more > 0.06 - 1e-9
    # an M/D/inf process: the share of time with no burst under way is exp(-rate duration)
    assert np.mean(held) == pytest.approx(1.0 - np.exp(-0.2 * 0.5), rel=0.12)
    assert np.max(more) == pytest.approx(0.06, abs=1e-9)
    begins = np.flatnonzero(held[1:] & ~held[:-1])
    lengths = [int(np.argmin(held[b + 1 :])) for b in begins[:-1]]
    assert min(lengths) >= int(0.5 * 65.0)
    # one that another prolongs is longer: 1 - exp(-0.1) of them at most
    assert np.mean(np.array(lengths) <= int(0.5 * 65.0) + 1) > 0.85
    # after it the queue empties one transfer apart: 60 ms of delay is gone within a few frames
    caught_up = (more > 1e-9) & ~held
    assert np.sum(caught_up) / len(begins) == pytest.approx(0.06 / (1.0 / 65.0 - TRANSFER_S), abs=1.0)


def test_a_stale_buffer_hands_over_an_older_image_under_the_new_number_and_stamp() -> None:
    effect = {"cause": "stale_frame_buffer", "onset_s": 4.0, "frames": 2}
    plain, stale = exposures(frames=600, stamped=True), exposures(effect, frames=600, stamped=True)
    for name in ("frame", "handover_s", "stamp_s", "readout_end_s"):
        assert np.array_equal(column(stale, name), column(plain, name))
    age = column(plain, "mid_s") - column(stale, "mid_s")
    after = column(plain, "start_s") - ORIGIN_S >= 4.0
    assert np.all(age[~after] == 0.0)
    assert age[after] == pytest.approx(np.full(np.sum(after), 2.0 / 65.0), abs=1e-9)
    assert column(plain, "start_s") - column(stale, "start_s") == pytest.approx(age, abs=1e-9)


def test_the_cameras_clock_steps_alone() -> None:
    effect = {"cause": "clock_step", "onset_s": 4.0, "step_s": -0.13, "clock": "camera"}
    plain, stepped = exposures(frames=600, stamped=True), exposures(effect, frames=600, stamped=True)
    jump = column(stepped, "stamp_s") - column(plain, "stamp_s")
    after = column(plain, "mid_s") - ORIGIN_S >= 4.0
    assert jump == pytest.approx(np.where(after, -0.13, 0.0), abs=1e-9)
    assert [row._replace(stamp_s=None) for row in stepped] == [row._replace(stamp_s=None) for row in plain]
    other = {**effect, "clock": "frames"}
    assert exposures(other, frames=600, stamped=True) == plain


def test_no_size_no_effect_to_the_bit() -> None:
    none: list[dict[str, Any]] = [
        {"cause": "camera_clock_skew", "skew_ppm": 0.0},
        {"cause": "frame_drops", "fraction": 0.0},
        {"cause": "delay_bursts", "rate_hz": 0.0, "duration_s": 0.1, "delay_s": 0.1},
        {"cause": "delay_drift", "rate_s_per_s": 0.0},
        {"cause": "stale_frame_buffer", "onset_s": 1.0, "frames": 0},
        {"cause": "clock_step", "onset_s": 1.0, "step_s": 0.0, "clock": "camera"},
    ]
    bare = CameraTiming(Camera(), Timing(), Rig(scene=SimulatedScene(stamped=True)), 3, origin_s=ORIGIN_S)
    assert exposures(*none, stamped=True) == [bare.expose() for _ in range(2000)]
