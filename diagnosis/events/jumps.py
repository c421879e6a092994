"""Where the free vibration's phasor jumps.

Over one period before and one after each instant, the residual's phasor at a mode's frequency; what stands out of the
usual jumps between the two, and is borne out by the other sensors, is a jump of the vibration.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import std_about_zero, without_spikes
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]
Series = tuple[Array, Array]
"""Times, s, and a sensor's residual there as deflection, m."""

PUSH_PERIODS = 1.6
"""That a push by hand lasts, at most: a longer one swings the arm while it lasts, and is a pull."""
_FEWEST, _FEWEST_INSTANTS = 50, 10  # samples, and instants to look at, that tell a jump from the usual ones
# of a higher mode, before and after an instant: a part of a first mode's swing as a rule
_HIGHER_PERIODS = 6.0
_GRID_S = 0.01  # between the instants looked at, unless 2 % of a period are more
_OUTSTANDING = 9.0  # times the median jump: by noise, whose jumps are Rayleigh's, one in 2^81
_NEAR = 5.0  # times the median of those near by: by noise one in 2^25
_NORMAL = 2.0  # times as many medians make a difference of amplitudes, which is normal, as rare as Rayleigh's
_LEAST_SHARE = 0.01  # of the arm's largest vibration
_AGREE = 0.6  # of a jump, by which another sensor may have it otherwise
_TURNED = 0.6  # sine of the angle, by which a jump that both show plainly may be turned: what a wrong delay makes of it
_APART_PERIODS = 1.2  # of the first mode, between jumps that one look finds
_MOST = 40  # jumps that one look finds


def _all_series(world: World, residuals: dict[str, Array], w: float, last: Fit) -> list[Series]:
    """Times and residual as deflection, m, of each channel that shows the vibration, the one with the least noise
    first."""
    choices = []
    grid = world.cycle_times
    for name, per in (
        ("deflection", 1.0),
        ("acceleration", -w * w * last.value("accelerometer.scale")),
        ("displacement", -last.value("camera.scale_px_per_m")),
    ):
        if name not in world.channels or per == 0.0:
            continue
        values = residuals[name] / per
        time = world.instants(last.vector) if name == "displacement" else grid
        known = np.isfinite(values)
        if known.sum() < _FEWEST:
            continue
        if name == "acceleration":
            values = without_spikes(values)
        quiet = std_about_zero(np.diff(values[known])) / np.sqrt(2.0)
        rate = known.sum() / world.measured.duration_s
        choices.append((quiet / np.sqrt(rate), time[known], values[known]))
    choices.sort(key=lambda choice: choice[0])
    return [(time, values) for _, time, values in choices]


def _phasor(time: Array, values: Array, w: float, start: Array, end: Array) -> tuple[Array, Array]:
    """Phasor of the values at w over each window, its mean taken off; and how many samples it has."""
    turn = np.exp(-1j * w * time)
    sums = [np.concatenate(([0.0], np.cumsum(one))) for one in (values * turn, turn, values)]
    first, last = np.searchsorted(time, start), np.searchsorted(time, end)
    count = np.maximum(last - first, 1)
    moved, plain, mean = (one[last] - one[first] for one in sums)
    return 2.0 * (moved - mean / count * plain) / count, (last - first).astype(float)


def find_jumps(last: Fit, share: float, elsewhere: bool = False) -> list[float]:
    """Times, s, at which the vibration jumps by more than `share` of the residual's largest and the usual: the first
    mode's, or while the joint rests a higher one's. An arm that rubs may hide an impact in its first mode alone.
    elsewhere: the residual's largest is that of the first mode away from the known impacts. What a push by hand leaves
    about its impact is its force, which may be far larger than the vibration after another push."""
    found: list[float] = []
    period = 1.0 / last.value("modes.0.frequency_hz")
    jumps = [*_jumps_of_the_first_mode(last, share, elsewhere), *_jumps_of_higher_modes(last, share)]
    for _, time in sorted(jumps, reverse=True)[:_MOST]:  # a large one shows in the others' windows, too
        if all(abs(time - other) > _APART_PERIODS * period for other in found):
            found.append(time)
    return sorted(found)


def _jumps_of_higher_modes(last: Fit, share: float) -> list[tuple[float, float]]:
    """Size, m/s^2, and time, s, of each. By the accelerometer, in which they are plain, over some periods of theirs,
    which last no longer than a swing; not about a move, which sets off more of them than a model foretells that is a
    little wrong."""
    world = last.world
    sensor = last.channel("acceleration")
    if sensor is None or world.measured.pair:
        return []
    known = np.isfinite(sensor.off)
    if known.sum() < _FEWEST:
        return []
    time, values = world.cycle_times[known], without_spikes(sensor.off[known])
    swing = 1.0 / last.value("modes.0.frequency_hz")
    turns = np.concatenate(([0], np.cumsum(world.measured.told_to_move)))
    found: list[tuple[float, float]] = []
    for mode in range(1, world.modes):
        hz = last.value(f"modes.{mode}.frequency_hz")
        reach = _HIGHER_PERIODS / hz
        if reach > swing or 2.0 * hz * world.measured.cycle_s > 1.0:
            continue
        at = np.arange(time[0] + reach, time[-1] - reach, max(_GRID_S, 0.02 * reach))
        if len(at) < _FEWEST_INSTANTS:
            continue
        before, n_before = _phasor(time, values, 2.0 * pi * hz, at - reach, at)
        after, n_after = _phasor(time, values, 2.0 * pi * hz, at, at + reach)
        jump = np.abs(after) - np.abs(before)  # a rest of a wrong frequency turns, and grows at no time
        full = np.minimum(n_before, n_after) > 0.5 * np.median(n_after)
        first, end = (
            np.clip(np.round((at + way * swing) / world.measured.cycle_s), 0, len(turns) - 1).astype(int)
            for way in (-1.0, 1.0)
        )
        jump[~full | (turns[end] > turns[first])] = 0.0
        usual = _usual(np.abs(jump), full, max(round(reach / float(at[1] - at[0])), 1))
        threshold = np.maximum(_NORMAL * usual, share * float(np.max(np.abs(after))))
        found += _largest(jump, threshold, at, _APART_PERIODS * swing)
    return found


def _largest(jump: Array, threshold: Array, at: Array, apart_s: float) -> list[tuple[float, float]]:
    """Size and time of the jumps that exceed what they have to, of those that are near each other the largest."""
    found: list[tuple[float, float]] = []
    for i in np.argsort(-jump):
        if len(found) >= _MOST or jump[i] <= 0.0:
            break
        if jump[i] >= threshold[i] and all(abs(at[i] - other) > apart_s for _, other in found):
            found.append((float(jump[i]), float(at[i])))
    return found


def _jumps_of_the_first_mode(last: Fit, share: float, elsewhere: bool) -> list[tuple[float, float]]:
    """Size, as the accelerometer would show it, m/s^2, and time, s, of each."""
    world = last.world
    w = 2.0 * pi * last.value("modes.0.frequency_hz")
    residuals = {name: values - last.predicted.channels[name] for name, values in world.channels.items()}
    series = _all_series(world, residuals, w, last)
    if not series:
        return []
    time, values = series[0]
    period = 2.0 * pi / w
    at = np.arange(time[0] + period, time[-1] - period, max(_GRID_S, 0.02 * period))
    if len(at) < _FEWEST_INSTANTS:
        return []
    before, n_before = _phasor(time, values, w, at - period, at)
    after, n_after = _phasor(time, values, w, at, at + period)
    jump = np.abs(after - before)
    full = np.minimum(n_before, n_after) > 0.5 * np.median(n_after)
    jump[~full] = 0.0
    usual = _usual(jump, full, round(period / float(at[1] - at[0])))
    swing = _LEAST_SHARE * float(np.max(np.abs(last.predicted.motion.q[:, 0])))
    about = _about_impacts(world, at, period) if elsewhere else np.zeros(len(at), bool)
    largest = float(np.max(np.abs(after[~about]), initial=0.0))
    jump[about] = 0.0
    threshold = np.maximum(usual, max(share * largest, swing))
    for other in series[1:]:
        borne_out = _borne_out(at, period, w, series[0], other)
        if not world.impacts and not (borne_out & (jump >= threshold)).any():
            borne_out = _borne_out(at, period, w, series[0], other, of_any_size=True)
        jump[~borne_out] = 0.0
    return [(w * w * size, time) for size, time in _largest(jump, threshold, at, _APART_PERIODS * period)]


def _about_impacts(world: World, at: Array, period: float) -> NDArray[np.bool_]:
    """Which instants a push by hand may take up whose impact is known, windows of a period included."""
    struck = np.array(world.impacts) * world.measured.cycle_s
    near = (PUSH_PERIODS / 2.0 + 1.0) * period
    return np.asarray((np.abs(at[:, None] - struck) < near).any(axis=1))


def _borne_out(
    at: Array, period: float, w: float, shown: Series, other: Series, of_any_size: bool = False
) -> NDArray[np.bool_]:
    """Whether another sensor shows the same jump: an impact moves the arm, and all that look at it; a sensor that has
    gone wrong moves its own reading. While a push by hand lasts, its force is another jump to each sensor: windows
    before and after it agree. Where the other sensor's noise hides it, it is taken for the same. of_any_size: also
    where the other shows it plainly, at the same phase or the opposite one: its scale may be wrong, even in sign, as
    long as no impact has told it."""
    agree, full = _same_jump(at, period, w, shown, other, 0.0, of_any_size)
    apart, full_apart = _same_jump(at, period, w, shown, other, PUSH_PERIODS / 2.0 * period, of_any_size)
    return agree | ~full | (apart & full_apart)


def _same_jump(
    at: Array, period: float, w: float, shown: Series, other: Series, gap: float, of_any_size: bool
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether two sensors' phasors jump alike across a gap, s, to either side of each instant; and whether the other
    sensor has enough samples to tell."""
    before, _ = _phasor(*shown, w, at - gap - period, at - gap)
    after, _ = _phasor(*shown, w, at + gap, at + gap + period)
    jump = after - before
    before, n_before = _phasor(*other, w, at - gap - period, at - gap)
    after, n_after = _phasor(*other, w, at + gap, at + gap + period)
    there = after - before
    full = np.minimum(n_before, n_after) > 0.5 * np.median(n_after)
    usual = float(np.median(np.abs(there[full]))) if full.any() else 0.0
    alike = np.abs(there - jump) < np.maximum(_AGREE * np.abs(jump), 3.0 * usual)
    if not of_any_size:
        return alike, full
    across = np.abs((there * np.conj(jump)).imag) < _TURNED * np.abs(there * jump)
    plain = np.abs(there) > _OUTSTANDING * usual
    return alike | (across & plain & (usual > 0.0)), full


def _usual(jump: Array, full: NDArray[np.bool_], period: int) -> Array:
    """What a jump has to exceed: several times the median of all, or of those near by if that is less, for an impact
    that is not yet found raises them all."""
    overall = _OUTSTANDING * float(np.median(jump[full])) if full.any() else 0.0
    reach, near = 5 * period, 3 * period // 2
    known = np.pad(np.where(full, jump, np.inf), reach, constant_values=np.inf)
    around = np.lib.stride_tricks.sliding_window_view(known, 2 * reach)  # row i: from i - reach on
    ordered = np.sort(np.delete(around[: len(jump)], np.s_[reach - near : reach + near], axis=1), axis=1)
    count = np.isfinite(ordered).sum(axis=1)
    row = np.arange(len(jump))
    middle = 0.5 * (ordered[row, np.maximum(count - 1, 0) // 2] + ordered[row, count // 2])
    return np.where(count > 3 * period, np.minimum(overall, _NEAR * middle), overall)
