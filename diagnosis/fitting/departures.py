"""Where a fit departs from a channel by far more than it usually does: about an event, or from an instant on."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import MIN_USUAL, std_about_zero, white_noise
from stillarm.diagnosis.fitting.fitted import Fit

Array = NDArray[np.float64]

LOUD_OVER_S = 0.02
"""Over which the accelerometer's departure is looked at, s."""
_LEAST_FRAMES = 3  # over which an image's is
_LOUD = 6.0  # times the usual departure, in which one window in a thousand lies by chance
_AS_LOUD = 0.1  # of the most about an impact
_LONG_FRAMES = 5  # over which an image's departure is looked at where it lasts
# times the usual departure, in which one window of so many in a hundred thousand lies by chance
_LONG_LOUD = 2.5
_HELD = 4.0  # times the usual mean of a window, in which six of normal ones in a hundred thousand lie
_GAP_PERIODS = 0.25  # within a stretch
_ABOUT_PERIODS = 0.35  # from an impact to where what it has wrong shows
_PARTS, _SAMPLES = 400, 10  # of the recording, in which levels are taken; of each, at least
_RUN = 3  # parts in a row that are louder: of noise alone thirty samples have no power that is four times the usual
_LOUDER, _PLAINLY = 1.3, 2.0  # times the level before: what sets in; what is plain against the beginning


def loud_at(
    last: Fit, name: str, width: int | None = None, times: float = _LOUD
) -> tuple[Array, NDArray[np.bool_]] | None:
    """When a channel was measured, s, and whether it departs from the model by far more than it usually does. width:
    samples over which it is looked at, if not the usual ones; times: the usual departure."""
    found = _departure(last, name)
    if found is None:
        return None
    time, off = found
    return time, loud_beside(off, off, width or _width(last, name), times)


def as_loud_about(
    last: Fit, name: str, struck: float, period: float
) -> tuple[Array, NDArray[np.bool_]] | None:
    """The same, by at least a tenth of the most that it does about an impact: where noise is little, what a wrong
    account of an impact leaves is far over the usual for long after."""
    found = _departure(last, name)
    if found is None:
        return None
    time, off = found
    loudness = _loudness(off, _width(last, name))
    near = np.abs(time - struck) < _ABOUT_PERIODS * period
    least = max(_AS_LOUD * float(loudness[near].max(initial=0.0)), _LOUD * _usual(off, loudness))
    return time, np.asarray(loudness > least)


def _departure(last: Fit, name: str) -> tuple[Array, Array] | None:
    """When a channel was measured, s, and its departure from the model, in its unit, without what is missing; None of a
    channel that is not there, or of which too little is known to have a usual departure."""
    if name not in last.residuals:
        return None
    off = last.residuals[name]
    known = np.isfinite(off)
    if known.sum() < MIN_USUAL:
        return None
    time = last.world.instants(last.vector) if name == "displacement" else last.world.cycle_times
    return time[known], off[known]


def _width(last: Fit, name: str) -> int:
    """Samples over which a channel's departure is looked at."""
    return max(_LEAST_FRAMES, round(LOUD_OVER_S / last.world.step_s(name)))


def stretches(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The runs of flags that are set, each by its first place and the place after its last. flags: (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def loud_beside(off: Array, usually: Array, width: int, times: float = _LOUD) -> NDArray[np.bool_]:
    """Where one departure, over so many samples, is so many times what another usually is. Both (n,), none missing."""
    return np.asarray(_loudness(off, width) > times * _usual(usually, _loudness(usually, width)))


def _loudness(off: Array, width: int) -> Array:
    """The rms of a departure over so many samples about each."""
    return np.asarray(np.sqrt(np.convolve(off**2, np.full(width, 1.0 / width), "same")))


def _usual(off: Array, loudness: Array) -> float:
    """What a departure's loudness is for most of the time."""
    return max(float(np.median(loudness)), white_noise(off))


def long_stretch(last: Fit, struck: float) -> tuple[float, float] | None:
    """The stretch about an impact in which the images depart from the model, s: a smaller departure than a loud one, as
    it lasts for some images; None where there is none."""
    loud = loud_at(last, "displacement", _LONG_FRAMES, _LONG_LOUD)
    if loud is None:
        return None
    # a period of which the gaps that are bridged are as many images
    as_long = _LONG_FRAMES * last.world.step_s("displacement") / _GAP_PERIODS
    return loud_stretch(*loud, struck, max(as_long, 1.0 / last.value("modes.0.frequency_hz")))


def is_one_sided(off: Array, width: int) -> NDArray[np.bool_]:
    """Where the mean of a departure over so many samples is by far more than it usually is: a force that holds shows in
    the mean while it is below the noise of one sample. off: (n,), none missing."""
    mean = np.abs(np.convolve(off, np.full(width, 1.0 / width), "same"))
    usual = max(std_about_zero(mean), white_noise(off) / width**0.5)
    return np.asarray(mean > _HELD * usual)


def loud_stretch(
    time: Array, loud: NDArray[np.bool_], struck: float, period: float
) -> tuple[float, float] | None:
    """The stretch in which a channel is loud that is nearest to an impact, across gaps of a quarter swing; None where
    it is not loud there."""
    at = time[loud]
    if not len(at):
        return None
    nearest = int(np.argmin(np.abs(at - struck)))
    if abs(at[nearest] - struck) > _ABOUT_PERIODS * period:
        return None
    # where nothing is judged, as at a stroke, it is not quiet either
    quiet_s = np.diff(np.flatnonzero(loud)) * float(np.median(np.diff(time)))
    breaks = np.flatnonzero(quiet_s > _GAP_PERIODS * period)
    first = breaks[breaks < nearest]
    last = breaks[breaks >= nearest]
    return float(at[first[-1] + 1 if len(first) else 0]), float(at[last[0] if len(last) else len(at) - 1])


def sets_in_s(last: Fit) -> list[float]:
    """Instants at which what a fit leaves in a channel grows, and half a swing before, s: there something may have set
    in. Of each channel the first that is plain against the beginning, the likeliest of two levels, one before and one
    after (Hinkley, Biometrika 57, 1970), and the same once more of what follows that (binary segmentation: Scott and
    Knott, Biometrics 30, 1974): an impact's ringing may have set in before."""
    world, swing_s = last.world, 1.0 / last.value("modes.0.frequency_hz")
    found: list[float] = []
    for name in ("acceleration", "deflection", "displacement", "joint_position"):
        if name not in last.residuals:
            continue
        time = world.times_of(name)
        known = np.isfinite(last.residuals[name])
        count = min(_PARTS, int(known.sum()) // _SAMPLES)
        if count < _RUN:
            continue
        parts = np.array_split(np.stack((time[known], last.residuals[name][known] ** 2)), count, axis=1)
        starts = np.array([part[0, 0] for part in parts])
        power = np.array([part[1].mean() for part in parts])
        places = {_first_louder(power), likeliest := _likeliest_louder(power)} - {None}
        if likeliest is not None and (later := _likeliest_louder(power[likeliest:])) is not None:
            places.add(likeliest + later)
        found += [float(starts[i]) for i in places]
    return [instant for one in found for instant in (one, max(one - 0.5 * swing_s, 0.0))]


def _first_louder(power: Array) -> int | None:
    """The first of the parts of a residual that is plainly louder than the first eighth of them, with those after."""
    beginning = len(power) // 8
    if beginning < _RUN:
        return None
    quiet = float(np.median(power[:beginning]))
    running = np.convolve(power, np.ones(_RUN) / _RUN, "valid")
    louder = np.flatnonzero(running[beginning:] > _PLAINLY**2 * quiet)
    return beginning + int(louder[0]) if len(louder) else None


def _likeliest_louder(power: Array) -> int | None:
    """Where the parts of a residual have most likely one level before and a higher one after; None where not."""
    at = np.arange(max(len(power) // 10, 1), len(power) - len(power) // 10)
    if len(at) < _RUN:
        return None
    sums = np.concatenate(([0.0], np.cumsum(power)))
    before, after = sums[at] / at, (sums[-1] - sums[at]) / (len(power) - at)
    nats = -at * np.log(np.maximum(before, 1e-300)) - (len(power) - at) * np.log(np.maximum(after, 1e-300))
    nats[after < _LOUDER**2 * before] = -np.inf
    best = int(np.argmax(nats))
    return int(at[best]) if np.isfinite(nats[best]) else None
