"""The simulated camera in virtual time: the same exposures and handovers, with images or without them."""

from collections import deque
from typing import NamedTuple

import numpy as np

from stillarm.common.files.configuration import Rig
from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model
from stillarm.common.recording.topics import TrueFrame
from stillarm.drivers.cameras.camera import Frame, GreyImage
from stillarm.simulation.arm.effect_clock import EffectClock
from stillarm.simulation.camera.camera_timing import CameraTiming, Exposure
from stillarm.simulation.camera.frame_timing_effects import FrameTimingEffects
from stillarm.simulation.camera.image_effects import image_effects
from stillarm.simulation.camera.image_motion import mean_displacement_px
from stillarm.simulation.camera.pose_history import PoseHistory
from stillarm.simulation.camera.renderer import Renderer

_STREAM = 0x7AC4E2
_REMEMBERED = 256


class Delivery(NamedTuple):
    """A frame that the driver hands over; image is None where images are skipped, stamp_s where unstamped."""

    truth: TrueFrame
    image: GreyImage | None
    stamp_s: float | None
    exposure_s: float

    def as_frame(self) -> Frame:
        """The frame as the camera's driver would return it. Raises ValueError if images are skipped."""
        if self.image is None:
            raise ValueError("images are skipped: ask for the tracked displacement instead")
        return Frame(self.image, self.truth.frame, self.stamp_s, self.exposure_s)


class VirtualCamera:
    """Exposes and delivers as virtual time passes. Deterministic: seed, poses and requests decide all."""

    def __init__(
        self,
        model: Model,
        rig: Rig,
        seed: int,
        history: PoseHistory,
        *,
        images: bool,
        origin_s: float = 0.0,
    ) -> None:
        """model: the true one; history: where the plant writes its poses, on the same virtual clock.

        images: whether to render; if not, tracked_displacement() stands in for the tracker. The same seed
        gives the same exposures and handovers either way.
        """
        model, clock = declared(model), EffectClock(origin_s)
        self._image_effects = image_effects(model, clock)
        self._camera = model.camera
        self._buffers = rig.scene.buffers
        self._history = history
        self._renderer = Renderer(model.camera, rig.scene, seed, self._image_effects) if images else None
        self._timing = CameraTiming(
            model.camera,
            model.timing,
            rig,
            seed,
            origin_s=origin_s,
            effects=FrameTimingEffects(model, seed, clock),
        )
        self._freerun = model.camera.mode == "freerun"
        self.triggered = not self._freerun
        self._noise = np.random.default_rng((seed, _STREAM))
        self._pending: deque[Exposure] = deque()
        self._tracked: dict[int, float] = {}
        self._idle_until_s = float("-inf")
        self.lost = 0

    def request(self, time_s: float) -> None:
        """Trigger an exposure. Raises ValueError in freerun."""
        self._pending.append(self._timing.request(time_s))
        self._idle_until_s = self._next_event_s()

    def due(self, now_s: float) -> list[Delivery]:
        """The frames handed over since the last call, in order; at the most as many as there are buffers.

        If several frames have come since the last call, the newest is returned, as by FrameRingReader; `lost` counts
        the rest, and those that an effect has lost. Times increase from call to call, after the poses up to
        `now_s` have been written. Raises LookupError where the history no longer holds a frame's exposure, or
        does not hold it yet.
        """
        if now_s < self._idle_until_s:  # nearly every call: kept cheap
            return []
        if self._freerun:
            while self._timing.next_start_s <= now_s:
                self._pending.append(self._timing.expose())
        handed: list[Exposure] = []
        while self._pending and self._pending[0].handover_s <= now_s:
            handed.append(self._pending.popleft())
        self._idle_until_s = self._next_event_s()
        if not handed:
            return []
        noise = self._noise.standard_normal(len(handed)).tolist()
        here = [(e, n) for e, n in zip(handed, noise, strict=True) if not e.lost]
        kept = here[-self._buffers :]
        self.lost += len(handed) - len(kept)
        return [self._deliver(e, n) for e, n in kept]

    def tracked_displacement(self, frame: int) -> float:
        """A tracker's result for a delivered frame, px: the displacement averaged over the exposure, plus noise.

        The noise is white and normal, with camera.noise_std_px. Raises KeyError for a frame that was not
        delivered or is long past (256 frames).
        """
        return self._tracked[frame]

    def _next_event_s(self) -> float:
        """When the next exposure starts (in freerun) or the next frame is handed over."""
        start = self._timing.next_start_s if self._freerun else float("inf")
        return min(start, self._pending[0].handover_s) if self._pending else start

    def _deliver(self, exposure: Exposure, noise: float) -> Delivery:
        image = None
        if self._renderer is not None:
            image = self._renderer.render(self._history.interpolate, exposure.start_s, exposure.frame)
        mean = mean_displacement_px(
            self._camera, self._history.interpolate, exposure.start_s, self._image_effects
        )
        self._tracked[exposure.frame] = mean + self._camera.noise_std_px * noise
        self._tracked.pop(exposure.frame - _REMEMBERED, None)
        truth = TrueFrame(exposure.handover_s, exposure.frame, exposure.mid_s, exposure.handover_s)
        return Delivery(truth, image, exposure.stamp_s, self._camera.exposure_s)
