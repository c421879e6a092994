"""What the camera shows of a motion, and when: instants, arrivals and displacement of each frame.

An exposure shows a scene's mean place, and how fast it passes; that part is compiled.
"""

from math import ceil, pi

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.frame_clock import FrameClock
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.physics.arm_motion import Motion
from stillarm.diagnosis.physics.declared_effects import effects_in, laws_at
from stillarm.diagnosis.physics.quantities import CAMERA_BEGIN, QUARTZ, SKEW, SKEW_BEGIN
from stillarm.diagnosis.physics.space import Space

Array = NDArray[np.float64]

_TIE_S = 2e-7  # between frames read at once
_SLOPE_S = 0.002  # the rate is taken over twice this


class Camera:
    """The camera of one recording. in_order_s: when each frame was read, s, (frames,), made to increase: a clock that
    is set back makes frames seem to come before those before them."""

    def __init__(self, measured: Measured, model: Model, space: Space, clock: FrameClock) -> None:
        """clock: of the frames."""
        self.measured, self.model, self.space, self.frame_clock = measured, model, space, clock
        received = measured.frames.received_s
        self.in_order_s: Array = np.maximum.accumulate(received) + _TIE_S * np.arange(len(received))

    def instants(self, vector: Array) -> Array:
        """Mid-exposure of each frame as the vector has it, s."""
        at, clock = self.space.place, self.frame_clock
        frames = self.measured.frames
        delay = vector[at["timing.capture_delay_s"]]
        if clock.arrival:
            stepped = self.in_order_s >= vector[at["timing.step_onset_s"]]
            instants = frames.received_s - delay - np.where(stepped, vector[at["timing.step_s"]], 0.0)
            instants = instants - vector[at["timing.delay_rate"]] * frames.received_s
        else:
            instants = self._due_s(vector) - delay
            if frames.asked:  # requests carry the time that stepped
                stepped = self.in_order_s >= vector[at["timing.step_onset_s"]]
                instants = instants - np.where(stepped, vector[at["timing.step_s"]], 0.0)
        frames_late = vector[at["timing.stale_frames"]]
        if frames_late:
            period = 1.0 / self.model.camera.frame_rate_hz
            stale = frames.received_s >= vector[at["timing.stale_onset_s"]]
            instants = instants - np.where(stale, frames_late * period, 0.0)
        known: Array = instants
        return known

    def _due_s(self, vector: Array) -> Array:
        """When each frame of the camera's clock arrives that is as late as all are, s: at the rate of its quartz, and
        with the further skew from when on that acts."""
        at, grid_s = self.space.place, self.frame_clock.grid_s
        begin_s, skew = vector[at[SKEW_BEGIN]], 1e-6 * vector[at[SKEW]]
        due = grid_s * (1.0 + 1e-6 * vector[at[QUARTZ]]) + vector[at["timing.arrival_s"]]
        more = skew * (np.maximum(due - begin_s, 0.0) if begin_s > 0.0 else grid_s)
        return np.asarray(due + more)

    def arrivals(self, vector: Array) -> Array:
        """When each frame should have been read, s."""
        at, frames = self.space.place, self.measured.frames
        middle = 0.5 * self.measured.duration_s
        due = self._due_s(vector) + vector[at["timing.delay_rate"]] * (frames.received_s - middle)
        if frames.asked:  # requests and arrivals step together
            return np.asarray(due)
        stepped = self.in_order_s >= vector[at["timing.step_onset_s"]]
        known: Array = due + np.where(stepped, vector[at["timing.step_s"]], 0.0)
        return known

    @property
    def exposed_cycles(self) -> int:
        """Cycles that an exposure lasts, rounded up."""
        return ceil(self.model.camera.exposure_s / self.measured.cycle_s)

    def scene_of(self, tip_m: Array, angle: Array, vector: Array) -> Array | None:
        """What the camera looks at more, px, where the tip is that much further and turned; None where it does not show
        it alike at all times and places."""
        at = self.space.place
        if vector[at[CAMERA_BEGIN]] > 0.0 or laws_at(effects_in(vector, at), "image"):
            return None
        if vector[at["camera.locking_sin_px"]] or vector[at["camera.locking_cos_px"]]:
            return None
        tilt = vector[at["camera.rotation_px_per_rad"]]
        return np.asarray(-vector[at["camera.scale_px_per_m"]] * tip_m - tilt * angle)

    def exposed_later(self, scene: Array, cycles: int, vector: Array) -> Array:
        """What the images show of a scene, px, that begins so many cycles after the recording does: at rest there, for
        longer than an exposure."""
        cycle_s = self.measured.cycle_s
        instants = self.instants(vector) - cycles * cycle_s
        value, rate = np.empty(len(instants)), np.empty(len(instants))
        expose(np.ascontiguousarray(scene), instants, self.model.camera.exposure_s, cycle_s, value, rate)
        return value

    def displacement(self, motion: Motion, tip_m: Array, vector: Array) -> tuple[Array, Array]:
        """Displacement of each frame, px, and its rate, px/s. tip_m: the tip's path, (n,)."""
        at, frames = self.space.place, self.measured.frames
        exposure_s, cycle_s = self.model.camera.exposure_s, self.measured.cycle_s
        tilt, begin_s = vector[at["camera.rotation_px_per_rad"]], vector[at[CAMERA_BEGIN]]
        later = tilt - self.space["camera.rotation_px_per_rad"].start if begin_s > 0.0 else 0.0
        with np.errstate(over="ignore", invalid="ignore"):  # of a trial in which the arm runs away
            scene = -vector[at["camera.scale_px_per_m"]] * tip_m - (tilt - later) * motion.tip_angle
        instants = self.instants(vector)
        value, rate = np.empty(len(instants)), np.empty(len(instants))
        expose(scene, instants, exposure_s, cycle_s, value, rate)
        value = value + vector[at["camera.offset_px"]]
        since = np.maximum(frames.received_s - begin_s, 0.0)
        if later:
            more, more_rate = np.empty(len(instants)), np.empty(len(instants))
            expose(-later * motion.tip_angle, instants, exposure_s, cycle_s, more, more_rate)
            value, rate = (
                value + np.where(since > 0.0, more, 0.0),
                rate + np.where(since > 0.0, more_rate, 0.0),
            )
        with np.errstate(over="ignore"):  # a candidate that runs away
            added = [
                np.where(since > 0.0, law(value, since), 0.0)
                for law in laws_at(effects_in(vector, at), "image")
            ]
            for one in added:
                value = value + one
        sine, cosine = vector[at["camera.locking_sin_px"]], vector[at["camera.locking_cos_px"]]
        if sine or cosine:
            value = value + sine * np.sin(2.0 * pi * value) + cosine * np.cos(2.0 * pi * value)
        return value, rate


@njit(cache=True, nogil=True, error_model="numpy")
def _place(scene: Array, x: float) -> float:
    """The scene at x samples, linear between them, held beyond its ends; NaN for NaN."""
    if np.isnan(x):
        return np.nan
    x = min(max(x, 0.0), scene.shape[0] - 1.0)
    k = min(int(x), scene.shape[0] - 2)
    place: float = scene[k] + (x - k) * (scene[k + 1] - scene[k])
    return place


@njit(cache=True, nogil=True, error_model="numpy")
def _mean(scene: Array, start: float, end: float) -> float:
    """Mean of the piecewise linear scene between two places, in samples, within it."""
    first, last = int(np.ceil(start)), int(np.floor(end))
    if last < first:
        return 0.5 * (_place(scene, start) + _place(scene, end))
    total = 0.5 * (first - start) * (_place(scene, start) + scene[first])
    for k in range(first, last):
        total += 0.5 * (scene[k] + scene[k + 1])
    total += 0.5 * (end - last) * (scene[last] + _place(scene, end))
    mean: float = total / (end - start)
    return mean


@njit(cache=True, nogil=True, error_model="numpy")
def expose(
    scene: Array, instants_s: Array, exposure_s: float, cycle_s: float, out_value: Array, out_rate: Array
) -> None:
    """Mean place over each exposure and its rate, 1/s, at mid-exposures `instants_s` (frames,).

    scene: (cycles,), linear between cycles. An exposure shorter than a cycle, or not wholly within the scene, shows
    the place at its middle.
    """
    last, slope = scene.shape[0] - 1.0, _SLOPE_S / cycle_s
    for i in range(instants_s.shape[0]):
        x, half = instants_s[i] / cycle_s, 0.5 * exposure_s / cycle_s
        if exposure_s >= cycle_s and x - half >= 0.0 and x + half <= last:
            out_value[i] = _mean(scene, x - half, x + half)
        else:
            out_value[i] = _place(scene, x)
        out_rate[i] = (_place(scene, x + slope) - _place(scene, x - slope)) / (2.0 * _SLOPE_S)
