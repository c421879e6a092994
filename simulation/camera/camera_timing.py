"""When the simulated camera exposes, and when its driver hands the frames over. Pure: values from a seed.

The law of the handover. Frame k's middle row is exposed around mid_k; the driver hands it over at

    h_k = max(mid_k + m + s (sqrt(f) g_k + sqrt(1 - f) e_k), end of read-out_k + transfer, h_(k-1) + transfer)

with g a first-order Gauss-Markov process (the operating system's slow wander: correlation exp(-|dt| / T), T =
rig.delay_wander_time_s), e white, both normal with unit variance, and f = rig.delay_wander_fraction. The two
bounds say that a frame cannot arrive before it was read out and transferred, and that frames arrive in
order. m and s are set, when the camera is made, so that mean and standard deviation of h - mid hold with the
bounds in force. Effects (frame_timing_effects) come on top: a drift and bursts are added to the delay before the
bounds, frames are lost, the period is skewed, an older image is handed over.
"""

from math import exp, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Rig
from stillarm.common.files.model import Camera, Timing
from stillarm.common.user_error import UserError
from stillarm.simulation.camera.frame_timing_effects import FrameTimingEffects

FloatArray = NDArray[np.float64]

TRANSFER_S = 0.001
"""From the end of the read-out to the earliest handover, and the least time from one handover to the next."""

AFTER_DELIVERY_S = 0.004
"""What follows the handover on average: tracking, the network, waiting for the controller's next cycle."""

_STREAM = 0xCA3E2A
_CLOCK_RATE_PPM = 50.0  # an ordinary crystal
_CLOCK_AGE_S = 1000.0
_CALIBRATION_FRAMES = 20000
_SETTLED_S = 1e-6
_MEAN_TOLERANCE, _STD_TOLERANCE = 0.01, 0.025


class Exposure(NamedTuple):
    """One frame's instants, s, on the rig's clock; stamp_s is mid_s on the camera's own clock, None if
    unstamped.

    mid_s is mid-exposure of the middle row. start_s and mid_s are those of the image that is handed over, which a
    stale buffer makes another one than frame and stamp say. lost: never handed over.
    """

    frame: int
    start_s: float
    mid_s: float
    readout_end_s: float
    handover_s: float
    stamp_s: float | None
    lost: bool = False


class CameraTiming:
    """Draws the exposures of one camera in their order, counting from 0."""

    def __init__(
        self,
        camera: Camera,
        timing: Timing,
        rig: Rig,
        seed: int,
        *,
        origin_s: float = 0.0,
        after_delivery_s: float = AFTER_DELIVERY_S,
        effects: FrameTimingEffects | None = None,
    ) -> None:
        """Freerun: frame k is exposed from t0 + k / frame_rate_hz, with t0 drawn within a frame after
        `origin_s`.

        after_delivery_s: how long it takes, on average, from the handover to the controller's reading of the
        visual sample; it is part of timing.capture_delay_s. Raises UserError when no handover can give the
        delay asked for.
        """
        self._camera = camera
        self._random = np.random.default_rng((seed, _STREAM))
        self._effects = effects
        self._period_s = 1.0 / camera.frame_rate_hz * (effects.period_ratio if effects is not None else 1.0)
        rolling = camera.shutter == "rolling"
        self._to_mid_s = 0.5 * camera.exposure_s + (0.5 * camera.readout_s if rolling else 0.0)
        self._to_readout_end_s = camera.exposure_s + camera.readout_s
        self._first_start_s = origin_s + self._period_s * float(self._random.random())
        self._clock_origin_s = origin_s - _CLOCK_AGE_S * float(self._random.random())
        self._clock_rate = 1.0 + 1e-6 * float(self._random.uniform(-_CLOCK_RATE_PPM, _CLOCK_RATE_PPM))
        self._stamped = rig.scene.stamped

        self._wander_time_s = rig.delay_wander_time_s
        self._wander_part = sqrt(rig.delay_wander_fraction)
        self._white_part = sqrt(1.0 - rig.delay_wander_fraction)
        self._wander = float(self._random.standard_normal())
        self._earliest_s = self._to_readout_end_s - self._to_mid_s + TRANSFER_S
        self._mean_s, self._std_s = self._calibrate(timing, after_delivery_s)

        self._frame = 0
        self._last_start_s = float("-inf")
        self._last_handover_s = float("-inf")

    @property
    def next_start_s(self) -> float:
        """Start of the exposure that comes next: in freerun exactly then, triggered not before then."""
        if self._camera.mode == "freerun":
            return self._first_start_s + self._frame * self._period_s
        return self._last_start_s + self._period_s

    def expose(self) -> Exposure:
        """The next exposure in freerun. Raises ValueError when the camera is triggered."""
        if self._camera.mode != "freerun":
            raise ValueError("a triggered camera exposes on request(time_s) only")
        return self._expose(self.next_start_s)

    def request(self, time_s: float) -> Exposure:
        """The exposure that a request at `time_s` triggers: at once, or as soon as the sensor's frame rate
        lets it.

        Raises ValueError in freerun.
        """
        if self._camera.mode != "triggered":
            raise ValueError("a camera in freerun takes no requests")
        return self._expose(max(time_s, self.next_start_s))

    def _expose(self, start_s: float) -> Exposure:
        if self._frame:
            kept = exp(-(start_s - self._last_start_s) / self._wander_time_s)
            step = float(self._random.standard_normal())
            self._wander = kept * self._wander + sqrt(1.0 - kept * kept) * step
        white = float(self._random.standard_normal())
        delay = self._mean_s + self._std_s * (self._wander_part * self._wander + self._white_part * white)
        mid = start_s + self._to_mid_s
        if self._effects is not None:
            delay += self._effects.further_delay_s(mid, mid + delay)
        handover = max(mid + delay, mid + self._earliest_s, self._last_handover_s + TRANSFER_S)
        stamp = self._clock_rate * (mid - self._clock_origin_s) if self._stamped else None
        exposure = Exposure(self._frame, start_s, mid, start_s + self._to_readout_end_s, handover, stamp)
        self._frame += 1
        self._last_start_s = start_s
        self._last_handover_s = handover
        return exposure if self._effects is None else self._affected(exposure, self._effects)

    def _affected(self, exposure: Exposure, effects: FrameTimingEffects) -> Exposure:
        """With the image that is really handed over, the stamp that the camera's clock gives, or lost."""
        start = effects.shown_start_s(exposure.start_s)
        stamp = exposure.stamp_s
        return exposure._replace(
            start_s=start,
            mid_s=start + self._to_mid_s,
            stamp_s=None if stamp is None else stamp + effects.stamp_step_s(exposure.mid_s),
            lost=effects.is_lost(),
        )

    def _calibrate(self, timing: Timing, after_delivery_s: float) -> tuple[float, float]:
        """m and s of the law, so that the delay with its bounds has the mean and the spread asked for.

        The effect of the bounds is measured against the unbounded delay in the same long sample, so that the sample's
        chance deviations cancel; without effect, m and s are exactly the requested values. For a triggered camera the
        requests are assumed to be so rare that the order binds nothing.
        """
        target_mean = timing.capture_delay_s - after_delivery_s
        target_std = timing.capture_delay_std_s
        least = self._earliest_s + after_delivery_s
        if target_mean < self._earliest_s:
            raise UserError(
                f"timing.capture_delay_s = {timing.capture_delay_s}: a frame needs {least:.4f} s from "
                "mid-exposure to the controller; give at least that, or shorten camera.exposure_s"
            )
        normal = self._unit_delays()
        in_order = self._camera.mode == "freerun"
        mean, std = target_mean, target_std
        for _ in range(40):
            free = mean + std * normal
            bounded = self._bounded(free, in_order)
            mean_error = target_mean - (mean + float(bounded.mean() - free.mean()))
            spread = float(bounded.std() / normal.std())
            if abs(mean_error) <= _SETTLED_S and abs(spread - target_std) <= _SETTLED_S:
                break
            mean += mean_error
            std *= target_std / spread if spread > 0.0 else 1.0
        mean_met = abs(mean_error) <= _MEAN_TOLERANCE * target_mean
        std_met = abs(spread - target_std) <= _STD_TOLERANCE * target_std + _SETTLED_S
        if mean_met and std_met and mean >= self._earliest_s:  # else most frames would come at the bound
            return mean, std
        raise UserError(
            f"timing.capture_delay_std_s = {target_std}: frames in order, and none before {least:.4f} s, "
            f"cannot spread so far about timing.capture_delay_s = {timing.capture_delay_s}; lower it"
        )

    def _unit_delays(self) -> FloatArray:
        """sqrt(f) g + sqrt(1 - f) e for many frames at the frame rate, the same at every call."""
        random = np.random.default_rng(_STREAM)
        kept = exp(-self._period_s / self._wander_time_s)
        steps = (sqrt(1.0 - kept * kept) * random.standard_normal(_CALIBRATION_FRAMES)).tolist()
        value = float(random.standard_normal())
        wander = []
        for step in steps:
            value = kept * value + step
            wander.append(value)
        white = random.standard_normal(_CALIBRATION_FRAMES)
        return self._wander_part * np.array(wander) + self._white_part * white

    def _bounded(self, delays: FloatArray, in_order: bool) -> FloatArray:
        """Delays after mid-exposure with the law's bounds, for frames at the frame rate."""
        delays = np.maximum(delays, self._earliest_s)
        if not in_order:
            return delays
        slack = (self._period_s - TRANSFER_S) * np.arange(len(delays))
        latest: FloatArray = np.maximum.accumulate(delays + slack)
        return latest - slack
