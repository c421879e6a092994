"""The simulated camera's process: exposes, renders the scene from the arm's motion, hands the images over when due."""

import contextlib
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan

import cv2

from stillarm.common.files.configuration import Configuration
from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model
from stillarm.common.recording.topics import TrueFrame
from stillarm.common.user_error import UserError
from stillarm.drivers.cameras.camera import GreyImage
from stillarm.drivers.cameras.frame_ring import FrameRingWriter
from stillarm.simulation.arm.effect_clock import EffectClock
from stillarm.simulation.camera.camera_timing import AFTER_DELIVERY_S, CameraTiming, Exposure
from stillarm.simulation.camera.frame_timing_effects import FrameTimingEffects
from stillarm.simulation.camera.image_effects import image_effects
from stillarm.simulation.camera.image_motion import FloatArray
from stillarm.simulation.camera.pose_history import PoseHistory, PoseNoLonger
from stillarm.simulation.camera.renderer import Renderer

_POLL_S = 0.001  # while waiting for a pose, for a request, or for the order to stop
_GIVE_UP_S = 0.5  # after its time: a plant that has not moved by then has stopped, and its frames are lost
_LATE_S = 0.001
_POSE_WAIT_S = 10.0


@dataclass
class CameraCounts:
    """Counts of the exposures by outcome. late: delivered more than a millisecond after their time."""

    delivered: int = 0
    late: int = 0
    lost: int = 0


@dataclass
class _Pending:
    exposure: Exposure
    image: GreyImage | None = None


class CameraLoop:
    """Decides what to do at which instant; clock, poses, renderer and ring are passed in.

    A frame is rendered as soon as the poses of its whole exposure are there, which leaves some 50 ms of time
    until its handover, and it is handed over in its order; a rendering that could still be under way when
    another frame falls due waits until that one is out.
    """

    def __init__(
        self,
        timing: CameraTiming,
        triggered: bool,
        *,
        covered_until: Callable[[], float],
        render: Callable[[Exposure], GreyImage],
        publish: Callable[[Exposure, GreyImage], None],
        requested: Callable[[], int],
        truth: Callable[[TrueFrame], None],
        clock: Callable[[], float],
    ) -> None:
        """covered_until: time of the newest pose; requested: frames asked for so far (of a triggered camera).

        `render` may raise PoseNoLonger: the frame is lost. All times are those of `clock`, s.
        """
        self._timing = timing
        self._triggered = triggered
        self._covered_until = covered_until
        self._render = render
        self._publish = publish
        self._requested = requested
        self._truth = truth
        self._clock = clock
        self._pending: deque[_Pending] = deque()
        self._served = 0
        self._rendering_s = 0.003  # how long a rendering takes: the slowest of late
        self.counts = CameraCounts()

    def step(self) -> float:
        """Do what is due, at most one rendering; returns the time at which to be called again."""
        now = self._clock()
        self._expose(now)
        self._hand_over(now)
        return self._render_next()

    def _expose(self, now: float) -> None:
        if self._triggered:
            requested = self._requested()
            while self._served < requested:
                self._served += 1
                self._take(self._timing.request(now))
            return
        while self._timing.next_start_s <= now:
            self._take(self._timing.expose())

    def _take(self, exposure: Exposure) -> None:
        if exposure.lost:
            self._report_lost(exposure)
        else:
            self._pending.append(_Pending(exposure))

    def _hand_over(self, now: float) -> None:
        pending, counts = self._pending, self.counts
        while pending and pending[0].exposure.handover_s <= now:
            exposure, image = pending[0].exposure, pending[0].image
            if image is None:
                if now < exposure.handover_s + _GIVE_UP_S:
                    return
                self._lose()
                continue
            pending.popleft()
            self._publish(exposure, image)
            delivered = self._clock()
            counts.delivered += 1
            counts.late += delivered > exposure.handover_s + _LATE_S
            self._truth(TrueFrame(delivered, exposure.frame, exposure.mid_s, delivered))

    def _render_next(self) -> float:
        """Render the first frame that can be, if there is time; returns when to look again."""
        wake = self._timing.next_start_s if not self._triggered else inf
        if self._pending and self._pending[0].image is not None:
            wake = min(wake, self._pending[0].exposure.handover_s)
        waiting = next((frame for frame in self._pending if frame.image is None), None)
        now = self._clock()
        if waiting is None:
            return wake
        exposure = waiting.exposure
        if self._covered_until() < exposure.readout_end_s:
            return min(wake, max(now + _POLL_S, exposure.readout_end_s))
        if wake_for_handover := self._handover_within(now):
            return wake_for_handover
        try:
            waiting.image = self._render(exposure)
        except PoseNoLonger:
            self._pending.remove(waiting)
            self._report_lost(exposure)
        self._rendering_s = max(self._clock() - now, 0.95 * self._rendering_s)
        return now

    def _handover_within(self, now: float) -> float | None:
        """When the first frame is ready and falls due before a rendering would end: that instant."""
        head = self._pending[0]
        due = head.exposure.handover_s
        return due if head.image is not None and due < now + 1.5 * self._rendering_s else None

    def _lose(self) -> None:
        self._report_lost(self._pending.popleft().exposure)

    def _report_lost(self, exposure: Exposure) -> None:
        self.counts.lost += 1
        self._truth(TrueFrame(exposure.handover_s, exposure.frame, exposure.mid_s, nan))


class _Poses:
    """The plant's pose history, opened anew when the plant has restarted."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._history = PoseHistory(name, wait_s=_POSE_WAIT_S)

    def newest_time_s(self) -> float:
        return self._history.newest_time_s()

    def interpolate(self, times_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._history.interpolate(times_s)

    def follow_restart(self) -> None:
        if self._history.replaced():
            with contextlib.suppress(UserError):  # removed, and not there again yet: the old one does no harm
                new = PoseHistory(self._name)
                self._history.close()
                self._history = new

    def close(self) -> None:
        self._history.close()


def pose_history_name(configuration: Configuration) -> str:
    """The shared memory through which the plant tells the camera where the tip was."""
    return f"{configuration.camera.device}-pose"


def run(
    configuration: Configuration,
    model: Model,
    seed: int,
    stop: Callable[[], bool],
    truth: Callable[[TrueFrame], None],
    *,
    after_delivery_s: float = AFTER_DELIVERY_S,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
    started: Callable[[], float] | None = None,
) -> CameraCounts:
    """Be the camera `configuration.camera.device` until stop() is true; returns what became of the frames.

    model: the true one. truth: takes one TrueFrame for each exposure, in order of handover; time_s is the
    handover (where a frame was lost: the one planned, and delivered_s is NaN). The poses' times are those of
    `clock`. started: when the recording started, inf while it has not; None: now. Raises UserError when the
    plant's pose history does not appear within ten seconds.
    """
    cv2.setNumThreads(1)
    scene, model = configuration.rig.scene, declared(model)
    effect_clock = EffectClock(clock() if started is None else started())
    renderer = Renderer(model.camera, scene, seed, image_effects(model, effect_clock))
    poses = _Poses(pose_history_name(configuration))
    timing = CameraTiming(
        model.camera,
        model.timing,
        configuration.rig,
        seed,
        origin_s=clock(),
        after_delivery_s=after_delivery_s,
        effects=FrameTimingEffects(model, seed, effect_clock),
    )
    ring = FrameRingWriter(configuration.camera.device, scene.width_px, scene.height_px, scene.buffers)
    loop = CameraLoop(
        timing,
        model.camera.mode == "triggered",
        covered_until=poses.newest_time_s,
        render=lambda e: renderer.render(poses.interpolate, e.start_s, e.frame),
        publish=lambda e, image: ring.publish(image, e.frame, e.stamp_s, model.camera.exposure_s),
        requested=ring.requested,
        truth=truth,
        clock=clock,
    )
    try:
        while not stop():
            if started is not None:
                effect_clock.origin_s = started()
            wake = loop.step()
            now = clock()
            if poses.newest_time_s() < now - _GIVE_UP_S:
                poses.follow_restart()
            if wake > now:
                sleep(min(wake - now, 10.0 * _POLL_S if model.camera.mode == "freerun" else _POLL_S))
    finally:
        ring.close()
        poses.close()
    return loop.counts
