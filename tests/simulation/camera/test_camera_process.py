"""The camera's schedule in virtual time: everything handed over when it should be, or counted."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import CameraDevice, Configuration, Rig, SimulatedScene
from stillarm.common.files.model import Camera, Model, Timing
from stillarm.common.recording.topics import TrueFrame
from stillarm.drivers.cameras.camera import GreyImage
from stillarm.drivers.cameras.frame_ring import FrameRingReader
from stillarm.simulation.arm.effect_clock import EffectClock
from stillarm.simulation.camera.camera_process import CameraLoop, pose_history_name, run
from stillarm.simulation.camera.camera_timing import CameraTiming, Exposure
from stillarm.simulation.camera.frame_timing_effects import FrameTimingEffects
from stillarm.simulation.camera.pose_history import PoseHistory, PoseNoLonger
from stillarm.simulation.camera.virtual_camera import Delivery, VirtualCamera


@dataclass
class _Bench:
    """A clock that advances only while rendering and between steps, and the camera's surroundings."""

    now: float = 0.0
    rendering_s: float = 0.003
    plant_lag_s: float = 0.0005
    plant_stops_s: float = float("inf")
    forgotten: frozenset[int] = frozenset()
    asked: Callable[[float], int] = field(default=lambda now: 0)
    published: list[tuple[int, float]] = field(default_factory=list)
    truths: list[TrueFrame] = field(default_factory=list)
    rendered: list[tuple[Exposure, float]] = field(default_factory=list)
    steps: int = 0

    def render(self, exposure: Exposure) -> GreyImage:
        if exposure.frame in self.forgotten:
            raise PoseNoLonger("gone")
        self.rendered.append((exposure, self.now))
        self.now += self.rendering_s
        return np.full((2, 2), exposure.frame % 256, dtype=np.uint8)

    def publish(self, exposure: Exposure, image: GreyImage) -> None:
        assert image[0, 0] == exposure.frame % 256
        self.published.append((exposure.frame, self.now))

    def loop(self, timing: CameraTiming, triggered: bool = False) -> CameraLoop:
        return CameraLoop(
            timing,
            triggered,
            covered_until=lambda: min(self.now - self.plant_lag_s, self.plant_stops_s),
            render=self.render,
            publish=self.publish,
            requested=lambda: self.asked(self.now),
            truth=self.truths.append,
            clock=lambda: self.now,
        )

    def run(self, loop: CameraLoop, until_s: float, nap_s: float = 0.01) -> None:
        while self.now < until_s:
            wake = loop.step()
            self.now = max(self.now, min(wake, self.now + nap_s))
            self.steps += 1


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    rendering_s=st.floats(0.0, 0.006),
    fraction=st.floats(0.0, 1.0),
    plant_lag_s=st.floats(0.0, 0.005),
)
def test_every_frame_is_handed_over_on_time_in_order_and_with_its_own_image(
    seed: int, rendering_s: float, fraction: float, plant_lag_s: float
) -> None:
    bench = _Bench(rendering_s=rendering_s, plant_lag_s=plant_lag_s)
    loop = bench.loop(CameraTiming(Camera(), Timing(), Rig(delay_wander_fraction=fraction), seed))
    bench.run(loop, 5.0)
    reference = CameraTiming(Camera(), Timing(), Rig(delay_wander_fraction=fraction), seed)
    planned = [reference.expose() for _ in range(400)]
    assert len(bench.published) >= 5.0 * 65 - 12
    assert [frame for frame, _ in bench.published] == list(range(len(bench.published)))
    for frame, at in bench.published:  # at most one rendering, taken for too short the first time, in its way
        assert -1e-9 <= at - planned[frame].handover_s <= rendering_s + 1e-9
    on_time = sum(at - planned[frame].handover_s < 1e-9 for frame, at in bench.published)
    assert on_time >= len(bench.published) - 8
    for exposure, at in bench.rendered:
        assert at - plant_lag_s >= exposure.readout_end_s - 1e-9
    assert [(t.frame, t.mid_exposure_s, t.delivered_s) for t in bench.truths] == [
        (frame, planned[frame].mid_s, at) for frame, at in bench.published
    ]
    assert loop.counts.lost == 0
    assert bench.steps < 65 * 5 * 14  # it sleeps between its duties


def test_a_renderer_that_is_too_slow_is_counted_late_and_keeps_the_order() -> None:
    bench = _Bench(rendering_s=0.02)  # longer than a frame
    loop = bench.loop(CameraTiming(Camera(), Timing(), Rig(), 3))
    bench.run(loop, 4.0)
    frames = [frame for frame, _ in bench.published]
    assert frames == sorted(frames)
    assert loop.counts.late > 100
    assert loop.counts.delivered == len(frames)


def test_frames_whose_poses_never_come_are_lost_and_told_so() -> None:
    bench = _Bench(plant_stops_s=2.0)
    loop = bench.loop(CameraTiming(Camera(), Timing(), Rig(), 3))
    bench.run(loop, 4.0)
    assert max(at for _, at in bench.published) < 2.2
    lost = [t for t in bench.truths if np.isnan(t.delivered_s)]
    assert loop.counts.lost == len(lost) > 60
    assert all(t.mid_exposure_s + 0.0075 > 2.0 for t in lost)
    assert [t.frame for t in bench.truths] == list(range(len(bench.truths)))
    bench.plant_stops_s = float("inf")  # the plant is back
    bench.run(loop, 5.0)
    assert bench.published[-1][1] > 4.9


def test_a_frame_whose_poses_are_gone_is_lost_and_the_next_one_is_not() -> None:
    bench = _Bench(forgotten=frozenset({10, 11}))
    loop = bench.loop(CameraTiming(Camera(), Timing(), Rig(), 3))
    bench.run(loop, 1.0)
    frames = [frame for frame, _ in bench.published]
    assert frames[8:12] == [8, 9, 12, 13]
    assert loop.counts.lost == 2


def test_a_triggered_camera_exposes_as_often_as_it_is_asked() -> None:
    bench = _Bench(asked=lambda now: int(now / 0.1))
    loop = bench.loop(CameraTiming(Camera(mode="triggered"), Timing(), Rig(), 3), triggered=True)
    bench.run(loop, 2.05, nap_s=0.001)
    assert len(bench.published) in (18, 19, 20)
    for exposure, _ in bench.rendered:
        assert exposure.start_s % 0.1 == pytest.approx(0.0, abs=0.005) or exposure.start_s % 0.1 > 0.099


def test_the_process_shows_the_supervisor_what_the_arm_did() -> None:
    device = f"test-camera-{os.getpid()}"
    configuration = Configuration(
        camera=CameraDevice(driver="shared_memory", device=device),
        rig=Rig(scene=SimulatedScene(width_px=96, height_px=64, stamped=True)),
    )
    history = PoseHistory(pose_history_name(configuration), create=True)
    now = 50.0
    history.append(now, 0.0, 0.0)
    truths: list[TrueFrame] = []
    frames = []
    reader: FrameRingReader | None = None

    def sleep(duration_s: float) -> None:
        nonlocal now, reader
        until = now + duration_s
        while now < until:
            now += 0.001
            history.append(now, 0.05 * (now - 50.0), 0.0)
        if reader is None:
            reader = FrameRingReader(device)
        while frame := reader.take():
            frames.append((frame.counter, frame.stamp_s, frame.exposure_s, frame.image.copy()))

    try:
        counts = run(
            configuration,
            Model(),
            7,
            lambda: now > 51.0,
            truths.append,
            clock=lambda: now,
            sleep=sleep,
        )
    finally:
        history.close()
        if reader is not None:
            reader.close()
    assert 50 <= counts.delivered <= 62
    assert counts.lost == 0
    assert [f[0] for f in frames] == [t.frame for t in truths][: len(frames)]
    assert len(frames) >= counts.delivered - 1
    assert all(f[1] is not None and f[2] == 0.015 for f in frames)
    assert len({f[3].tobytes() for f in frames}) == len(frames)

    delivered = _deliveries(Model(), configuration.rig, 7, 50.0, 51.2)
    assert len(delivered) >= len(frames)
    for (counter, stamp, _, image), delivery in zip(frames, delivered, strict=False):
        assert delivery.truth.frame == counter
        assert delivery.stamp_s == stamp
        assert delivery.image is not None
        assert np.abs(delivery.image.astype(int) - image).max() <= 1  # the poses' rows lie at other instants


def _deliveries(model: Model, rig: Rig, seed: int, origin_s: float, end_s: float) -> list[Delivery]:
    history = PoseHistory(None)
    camera = VirtualCamera(model, rig, seed, history, images=True, origin_s=origin_s)
    delivered: list[Delivery] = []
    for step in range(round((end_s - origin_s) * 1000) + 1):
        now = origin_s + 0.001 * step
        history.append(now, 0.05 * (now - origin_s), 0.0)
        for delivery in camera.due(now):
            assert now - 0.00101 < delivery.truth.delivered_s <= now
            delivered.append(delivery)
    return delivered


def test_a_frame_that_an_effect_loses_is_told_of_and_holds_up_nobody() -> None:
    model = Model(effects=[{"cause": "frame_drops", "fraction": 0.3}])
    effects = FrameTimingEffects(model, 2, EffectClock())
    timing, same = (CameraTiming(Camera(), Timing(), Rig(), 2, effects=e) for e in (effects, None))
    bench = _Bench()
    loop = bench.loop(timing)
    bench.run(loop, 5.0)
    lost = {t.frame for t in bench.truths if np.isnan(t.delivered_s)}
    published = {frame for frame, _ in bench.published}
    assert len(lost) == loop.counts.lost > 50 and loop.counts.late == 0
    assert not lost & published
    assert lost | published >= set(range(max(published)))
    handovers = {e.frame: e.handover_s for e in (same.expose() for _ in range(330))}
    assert all(handovers[frame] <= at <= handovers[frame] + 0.001 for frame, at in bench.published)


def test_effects_count_their_time_from_the_recordings_start() -> None:
    """Before that a drift is zero; the camera's process learns the start while it runs."""
    clock = EffectClock.waiting()
    model = Model(effects=[{"cause": "delay_drift", "rate_s_per_s": 0.01}])
    timing = CameraTiming(
        Camera(), Timing(capture_delay_std_s=0.0), Rig(), 2, effects=FrameTimingEffects(model, 2, clock)
    )
    before = [timing.expose() for _ in range(65)]
    clock.origin_s = 1.0
    after = [timing.expose() for _ in range(65)]
    assert [e.handover_s - e.mid_s for e in before] == pytest.approx([0.07] * 65, abs=1e-9)
    drifted = [0.07 + 0.01 * max(0.0, e.mid_s - 1.0) for e in after]
    assert [e.handover_s - e.mid_s for e in after] == pytest.approx(drifted, abs=1e-9)
