"""Noise laws of the channels: level, and for arrivals colour, so that a slow wander of the delay is no discovery.

Some sensors are finer than the simulation, or the tracker, is taken to be right (`LEAST`): they are told by their steps
and their noise.
"""

from dataclasses import dataclass
from math import inf, log, pi, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.data.robust import in_differences, std_about_zero, white_noise

Array = NDArray[np.float64]

MIN_ARRIVALS = 60
"""Frames whose arrivals tell a law of the delay, two seconds of them at 30 Hz: of fewer none is learnt."""
HUBER = 4.0
"""Standard deviations from which on a residual counts in proportion to its size, not to its square (Huber, Annals of
Mathematical Statistics 35, 1964): six normal values in a hundred thousand lie beyond."""
_LEVEL_STEPS = 4  # of a fixed-point iteration that gains a digit a step where outliers are few
LEAST = {
    "acceleration": 1e-3,
    "joint_position": 1e-4,  # a 16-bit encoder
    "joint_velocity": 1e-3,
    "deflection": 0.0,
    "displacement": 1e-2,  # trackers stray by as much
    "arrival": 2e-5,
}
"""Noise that a channel is taken to have at least, in its unit: the simulation, or a tracker, is no nearer the truth."""
MATTERS_OF_NOISE = 0.5
"""A rest that matters is over this part of a channel's noise (contract.md)."""
MATTERS_OF_MOTION = 1.0 / 2000.0
"""A rest that matters is over this part of its channel's own variation, too (contract.md)."""
MATTERS_AT_LEAST = {"displacement": 0.02, "arrival": 20e-6}
"""And over this, px and s (contract.md)."""
_FINE = 0.5  # of the least level
_SAME = 1e-9  # rad: values that a file's rounding alone tells apart
_FEWEST = 200  # known values: fewer do not tell how fine a sensor is
_QUIET = 0.1  # of the pieces, which are as quiet as the image gets
_PIECE = 32  # frames: a second at 30 Hz


@dataclass(frozen=True)
class Colour:
    """First-order wander plus white noise, as the filter that whitens it: e_k = r_k - stay r_{k-1} + moving e_{k-1}."""

    stay: float = 0.0
    moving: float = 0.0

    def whiten(self, residual: Array) -> Array:
        """Innovations of a residual; missing ones are taken as zero on the way and stay missing."""
        if self.stay == 0.0:
            return residual
        filled = np.nan_to_num(residual)
        white: Array = lfilter([1.0, -self.stay], [1.0, -self.moving], filled)
        white[0] = filled[0] * sqrt(max(1e-9, 1.0 - self.stay**2))
        return np.where(np.isnan(residual), np.nan, white)

    @property
    def strayed(self) -> float:
        """Deviation of what it whitens, in deviations of the innovations: an ARMA(1, 1) process's."""
        return sqrt(1.0 + (self.stay - self.moving) ** 2 / max(1.0 - self.stay**2, 1e-12))

    @property
    def wandered(self) -> float:
        """Deviation of the wander alone, in deviations of the innovations. The white noise's variance is moving / stay
        of theirs: in the Kalman filter's steady state both ratios are 1 - gain."""
        return sqrt(max(self.strayed**2 - self.moving / self.stay, 0.0)) if self.stay else 0.0


_TIMES = 12  # correlation times tried, in equal ratios


# of the variance, that wander: a grid, finer where almost none or almost all of it does
_SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.96, 0.985)


_WANDER_NATS = 6.0  # to gain over white noise: _TIMES by _SHARES, 132 laws, are tried, and log 132 = 4.9


@dataclass(frozen=True)
class WanderLaw:
    """A law of the arrivals. std: of its innovations; nats: its restricted log-likelihood, but for a constant."""

    colour: Colour
    std: float
    nats: float


def wander_colour(residual: Array, longest_frames: float, most: float = inf) -> Colour:
    """Colour of an arrival residual: that of `wander_law`; none where too few arrivals tell one."""
    law = wander_law(residual, longest_frames, most)
    return Colour() if law is None else law.colour


def wander_law(residual: Array, longest_frames: float, most: float = inf) -> WanderLaw | None:
    """Law of an arrival residual by restricted maximum likelihood: a straight trend is projected out, and what it
    takes with it of a slow wander is allowed for (Patterson and Thompson, Biometrika 58, 1971). None where there are
    too few arrivals.

    Without that a wander as long as the recording would seem shorter and smaller than it is, and a drift surer.
    longest_frames: a wander may last so long, not longer: what lasts longer is a drift. most: nor may it stray
    further.
    """
    r = residual[np.isfinite(residual)]
    n = len(r)
    if n < MIN_ARRIVALS:
        return None
    x = np.linspace(-1.0, 1.0, n)
    r = r - np.median(r)
    r = r - x * float(x @ r) / float(x @ x)
    limit = 4.0 * std_about_zero(r) + 1e-12
    columns = np.stack((np.ones(n), x, np.clip(r - r.mean(), -limit, limit)))
    plain, std = _restricted(columns)
    best, found = plain + _WANDER_NATS, WanderLaw(Colour(), std, plain)
    for one in wander_colours(longest_frames):
        nats, std = _restricted(lfilter([1.0, -one.stay], [1.0, -one.moving], columns)[:, 1:])
        if nats > best and std * one.wandered <= most:
            best, found = nats, WanderLaw(one, std, nats)
    return found


def wander_colours(longest_frames: float) -> list[Colour]:
    """The laws that a wander in white noise is looked for among: correlation times from two frames on, shares of the
    variance that wander."""
    return [
        _steady(1.0 - 1.0 / float(time), share, 1.0 - share)
        for time in np.geomspace(2.0, longest_frames, _TIMES)
        for share in _SHARES
    ]


def _restricted(columns: Array) -> tuple[float, float]:
    """Restricted log-likelihood per sample of the last row as white noise about the others, times their number; and the
    noise's deviation."""
    design, values = columns[:-1], columns[-1]
    normal = design @ design.T
    left = float(values @ values - (design @ values) @ np.linalg.solve(normal, design @ values))
    free = columns.shape[1] - len(design)
    _, spread = np.linalg.slogdet(normal)
    variance = max(left / free, 1e-30)
    return -0.5 * free * log(variance) - 0.5 * float(spread), sqrt(variance)


def _steady(stay: float, wander: float, white: float) -> Colour:
    """Innovations form of wander (variance, correlation from sample to sample) in white noise: the Riccati equation's
    steady state."""
    drive = wander * (1.0 - stay**2)
    b = white * (1.0 - stay**2) - drive
    p = 0.5 * (-b + sqrt(b * b + 4.0 * white * drive))
    gain = p / (p + white)
    return Colour(stay, stay * (1.0 - gain))


@njit(cache=True, nogil=True)
def _doubt_gains(
    rate: Array,
    gap_s: Array,
    noise: float,
    wander: float,
    white: float,
    per_s: float,
    gains: Array,
    stds: Array,
) -> None:
    """Gains and innovation deviations of a scalar Kalman filter: wander seen through rate, in noise."""
    p = wander
    for k in range(rate.shape[0]):
        if k:
            stay = np.exp(-gap_s[k] * per_s)
            p = stay * stay * p + wander * (1.0 - stay * stay)
        v = rate[k]
        s = v * v * (p + white) + noise
        gains[k] = p * v / s
        stds[k] = np.sqrt(s)
        p -= gains[k] * v * p


@njit(cache=True, nogil=True)
def _doubt_innovations(
    values: Array, rate: Array, gap_s: Array, per_s: float, gains: Array, out: Array
) -> None:
    late = 0.0
    for k in range(values.shape[0]):
        if k:
            late *= np.exp(-gap_s[k] * per_s)
        if np.isnan(values[k]):
            out[k] = np.nan
            continue
        out[k] = values[k] - rate[k] * late
        late += gains[k] * out[k]


class InstantUncertainty:
    """Displacement of a triggered camera: each frame's instant is off by a delay that wanders and scatters.

    r_k = rate_k (wander_k + white_k) + noise. Innovations are scaled to the deviation that they would have at rest,
    so that one level describes them all.
    """

    def __init__(
        self,
        rate_px_s: Array,
        received_s: Array,
        noise_px: float,
        spread_s: float,
        share: float,
        time_s: float,
    ) -> None:
        """share: of the delay's variance that wanders; time_s: its correlation time."""
        self._rate = rate_px_s
        self._gap = np.concatenate(([0.0], np.maximum(np.diff(received_s), 0.0)))
        self._per_s = 1.0 / time_s
        n = len(rate_px_s)
        self._gains, self.stds = np.empty(n), np.empty(n)
        self.noise_px = noise_px
        _doubt_gains(
            rate_px_s, self._gap, noise_px**2, share * spread_s**2, (1.0 - share) * spread_s**2, self._per_s,
            self._gains, self.stds,
        )  # fmt: skip

    def whiten(self, residual: Array) -> Array:
        """Scaled innovations of a residual, or of a change of the prediction."""
        out = np.empty(len(residual))
        _doubt_innovations(
            np.ascontiguousarray(residual), self._rate, self._gap, self._per_s, self._gains, out
        )
        return out * (self.noise_px / self.stds)


def doubt_colour(
    residual: Array, rate_px_s: Array, received_s: Array, noise_px: float, spread_s: float
) -> InstantUncertainty:
    """The likeliest share and correlation time of the delay's wander, its spread at most as stated."""
    known = np.isfinite(residual)
    best: tuple[float, InstantUncertainty] | None = None
    for size in (0.3, 0.6, 1.0, 1.3):
        for share in (0.0, 0.4, 0.8, 0.97):
            for time_s in (0.3, 1.0, 3.0, 10.0, 30.0) if share else (1.0,):
                one = InstantUncertainty(rate_px_s, received_s, noise_px, size * spread_s, share, time_s)
                scaled = one.whiten(residual)[known] / noise_px
                short = np.minimum(scaled * scaled, 25.0)
                cost = float(0.5 * np.sum(short) + np.sum(np.log(one.stds[known])))
                if best is None or cost < best[0]:
                    best = (cost, one)
    assert best is not None
    return best[1]


def level(residual: Array, least: float) -> float:
    """Standard deviation of a residual, its outliers bounded."""
    if not len(residual):
        return max(least, 1e-12)
    with np.errstate(over="ignore"):  # a candidate that runs away
        power = float(np.sqrt(np.mean(residual * residual)))
    limit = HUBER * max(std_about_zero(residual), least, 0.2 * power)
    with np.errstate(over="ignore"):
        short = np.clip(residual, -limit, limit)
        return max(float(np.sqrt(np.mean(short * short))), least, 1e-12)


def likeliest_level(residual: Array, begun: float, least: float) -> float:
    """The deviation at which a residual is likeliest with Huber's tails (`log_likelihood`): s^2 = mean of min(r^2,
    HUBER s |r|), from `begun` on. residual: (n,), none missing."""
    if not len(residual):
        return begun
    size, now = np.abs(residual), begun
    with np.errstate(over="ignore"):
        for _ in range(_LEVEL_STEPS):
            now = max(float(np.sqrt(np.mean(size * np.minimum(size, HUBER * now)))), least, 1e-12)
    return now


def log_likelihood(u: Array, std: float) -> Array:
    """Per sample: normal in the middle, with Huber's tails; u: residual over its standard deviation `std`."""
    size = np.abs(u)
    cost = np.where(size < HUBER, 0.5 * u * u, HUBER * size - 0.5 * HUBER**2)
    result: Array = -cost - log(std) - 0.5 * log(2.0 * pi)
    return result


def is_fine_encoder(position: Array) -> bool:
    """Whether a joint's position, (n,) rad, NaN where unmeasured, has noise and steps well below its least level."""
    known = position[np.isfinite(position)]
    if len(known) < _FEWEST:
        return False
    noise = white_noise(known, 2)
    return bool(max(resolution(known), noise) < _FINE * LEAST["joint_position"])


def resolution(values: Array) -> float:
    """The least step between successive values that differ, in their unit, which for values on a grid is its step; inf
    where none differ. values: (n,), none missing."""
    steps = np.abs(np.diff(values))
    return float(np.min(steps, initial=np.inf, where=steps > _SAME))


def is_fine_image(displacement_px: Array) -> bool:
    """Whether an image's noise lies below what trackers stray: by fifth differences, which show hardly anything of a
    motion that is slow beside the frames, in the quietest pieces. displacement_px: (n,), NaN where unmeasured."""
    fifth = np.diff(displacement_px, 5)
    count = len(fifth) // _PIECE
    if count * _PIECE < _FEWEST:
        return False
    pieces = fifth[: count * _PIECE].reshape(count, _PIECE)
    whole = pieces[np.isfinite(pieces).all(axis=1)]
    if not len(whole):
        return False
    noise = np.sqrt(np.mean(whole**2, axis=1)) / in_differences(5)
    return float(np.quantile(noise, _QUIET)) < LEAST["displacement"]


def fast_noise(acceleration: Array) -> float:
    """Deviation of an accelerometer's white noise, m/s^2, by fifth differences, in which no motion of the arm shows.
    acceleration: (n,), NaN where unmeasured."""
    return white_noise(acceleration, 5)
