"""Whether a move is safe to repeat at twice the velocity, by what the sensors show of it. Pure, cheap a sample."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from stillarm.diagnosis.commissioning.plan import Limits, Stage
from stillarm.diagnosis.data.measured import Measured

_UNSEEN_S = 0.5


@dataclass(frozen=True)
class Bounds:
    """What the sensors may show at most; the joint's and the image's from where they were at the start."""

    angle_rad: float
    image_px: float
    acceleration_m_s2: float


def bounds_of(limits: Limits, range_m_s2: float) -> Bounds:
    """The bounds that follow from the limits. The joint may overshoot by a quarter."""
    return Bounds(1.25 * limits.angle_rad, limits.image_px, limits.range_share * range_m_s2)


class Watch:
    """Takes samples in order and says what is exceeded, in one line, from then on."""

    def __init__(self, bounds: Bounds) -> None:
        """Nothing seen yet."""
        self._bounds = bounds
        self._theta0 = self._image0 = float("nan")
        self._mean, self._count = 0.0, 0
        self._seen_s: float | None = None
        self.exceeded: str | None = None
        self.swing_px = 0.0
        self.swing_m_s2 = 0.0

    def cycle(self, time_s: float, acceleration_m_s2: float, position_rad: float) -> None:
        """A cycle's samples; NaN where not measured."""
        bounds = self._bounds
        if isfinite(position_rad):
            if not isfinite(self._theta0):
                self._theta0 = position_rad
            if abs(position_rad - self._theta0) > bounds.angle_rad:
                self._say(f"the joint is {abs(position_rad - self._theta0):.3f} rad from its start")
        if isfinite(acceleration_m_s2):
            if self._count < 500:  # at rest: gravity's share and bias
                self._count += 1
                self._mean += (acceleration_m_s2 - self._mean) / self._count
            size = abs(acceleration_m_s2 - self._mean)
            self.swing_m_s2 = max(self.swing_m_s2, size)
            if abs(acceleration_m_s2) > bounds.acceleration_m_s2:
                self._say(
                    f"the accelerometer shows {abs(acceleration_m_s2):.3g} m/s^2, near the end of its range"
                )
        if self._seen_s is not None and time_s - self._seen_s > _UNSEEN_S:
            self._say(f"no image was measured for {_UNSEEN_S:g} s")

    def image(self, time_s: float, displacement_px: float) -> None:
        """A measured image."""
        self._seen_s = time_s
        if not isfinite(self._image0):
            self._image0 = displacement_px
        size = abs(displacement_px - self._image0)
        self.swing_px = max(self.swing_px, size)
        if size > self._bounds.image_px:
            self._say(f"the image has moved by {size:.0f} px")

    def _say(self, what: str) -> None:
        if self.exceeded is None:
            self.exceeded = what


@dataclass(frozen=True)
class Growth:
    """How far the probe got: greatest safe velocity, rad/s (0: none), and what ended it, if anything did."""

    velocity_rad_s: float
    ended_by: str | None
    swing_px: float


def growth(measured: Measured, plan: list[Stage], bounds: Bounds) -> Growth:
    """Judge a probe by its recording, whole or cut off where the watch ended it."""
    watch, safe, swing, seen = Watch(bounds), 0.0, 0.0, 0
    for stage in plan:
        last = round(stage.end_s / measured.cycle_s)
        _replay(watch, measured, seen, min(last, measured.cycles))
        seen = last
        if watch.exceeded is not None or last > measured.cycles:
            break
        safe, swing = stage.velocity_rad_s, watch.swing_px
    return Growth(safe, watch.exceeded, swing)


def exceeded(measured: Measured, bounds: Bounds) -> str | None:
    """What a recording shows to have gone beyond the bounds, first."""
    watch = Watch(bounds)
    _replay(watch, measured, 0, measured.cycles)
    return watch.exceeded


def _replay(watch: Watch, measured: Measured, first: int, last: int) -> None:
    """Cycles `first` to `last` - 1 of a recording, with the images that were read in them."""
    frames, cycle_s = measured.frames, measured.cycle_s
    at = int(np.searchsorted(frames.received_s, first * cycle_s - 0.5 * cycle_s))
    for k in range(first, last):
        now = k * cycle_s
        while at < len(frames) and frames.received_s[at] < now + 0.5 * cycle_s:
            if isfinite(frames.displacement_px[at]):
                watch.image(now, float(frames.displacement_px[at]))
            at += 1
        watch.cycle(now, float(measured.acceleration[k]), float(measured.position[k]))
