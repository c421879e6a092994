"""What one hidden rig truly is. Names are this world's own; `bundle.py` alone knows the model file's."""

from dataclasses import dataclass
from math import cos, cosh, pi, sin, sinh

TICK_S = 0.001
"""The controller's cycle."""
FINE = 10
"""Integration steps a cycle: 0.1 ms."""
STEP_S = TICK_S / FINE


@dataclass(frozen=True)
class Bend:
    """A bending shape: Hz, damping ratio, and what share of the root's motion excites it."""

    hertz: float
    loss: float
    share: float


@dataclass(frozen=True)
class Joint:
    """Velocity-controlled joint: first-order lag (Hz) after a hold-up (s), its limits, and its encoder."""

    follow_hertz: float
    hold_up_s: float
    top_speed: float
    top_acceleration: float
    encoder_step: float
    """rad; the position is rounded to it."""
    encoder_noise: float
    rate_noise: float
    """rad/s, on the measured velocity."""
    start_angle: float = 0.0


@dataclass(frozen=True)
class Feeler:
    """Accelerometer at the tip: gain (signed), lateness (s), white noise, bias and rounding in m/s^2, limit."""

    gain: float
    lateness_s: float
    hiss: float
    bias: float
    limit: float
    grain: float


@dataclass(frozen=True)
class Eye:
    """Camera at the tip, and how late its images are."""

    free: bool
    """True: exposures at phase_s + k / rate; False: each is triggered."""
    rate: float
    open_s: float
    """Exposure time, s."""
    px_per_m: float
    px_noise: float
    centre_px: float
    """Offset of the image displacement."""
    late_s: float
    late_spread_s: float
    slow_part: float
    """Part of the delay's variance that wanders slowly."""
    slow_s: float
    """Correlation time of that part."""
    phase_s: float
    stamped: bool
    stamp_offset_s: float
    stamp_ppm: float
    counts_exposures: bool
    """True: the frame number counts exposures; False: arrivals."""


@dataclass(frozen=True)
class Rig:
    """One arm with everything on it. reach: length, m."""

    reach: float
    bends: tuple[Bend, ...]
    joint: Joint
    feeler: Feeler
    eye: Eye
    gauge_noise: float
    """m, of a direct measurement of the deflection."""

    @property
    def usual_bending(self) -> float:
        """What moves are planned to bend it by, m."""
        return 0.008 * self.reach

    def root_acceleration(self, bending: float) -> float:
        """rad/s^2 of the joint, switched on, that swings the first bend to a peak, m: w^2 q / (2 share reach)."""
        first = self.bends[0]
        return (2.0 * pi * first.hertz) ** 2 * bending / (2.0 * first.share * self.reach)

    def root_step(self, bending: float) -> float:
        """rad/s of a sudden change of the joint's speed that does the same: w q / (share reach)."""
        first = self.bends[0]
        return 2.0 * pi * first.hertz * bending / (first.share * self.reach)

    @property
    def slopes(self) -> tuple[float, ...]:
        """Slope of the tip per tip deflection of each bend, rad/m."""
        return tuple(tip_slope(order) / self.reach for order in range(len(self.bends)))


_ROOTS = (1.8751040687119611, 4.694091132974174, 7.854757438237613)


def tip_slope(order: int) -> float:
    """length * phi'(length) / phi(length) of a clamped-free uniform beam: 1.3765, 4.781, 7.849.

    phi = cosh bx - cos bx - k (sinh bx - sin bx), k = (cosh bl + cos bl) / (sinh bl + sin bl), 1 + cos bl cosh bl = 0.
    """
    bl = _ROOTS[order]
    k = (cosh(bl) + cos(bl)) / (sinh(bl) + sin(bl))
    value = cosh(bl) - cos(bl) - k * (sinh(bl) - sin(bl))
    slope = sinh(bl) + sin(bl) - k * (cosh(bl) - cos(bl))
    return bl * slope / value
