"""Impacts that no sensor measured: where the free vibration's phasor jumps.

Over one period before and one after each instant, the residual's phasor at the first mode's frequency; an impact is a
jump between the two that stands out of the usual ones. It opens a new segment with its own state.
"""

from collections.abc import Callable
from dataclasses import replace
from math import pi

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.robust import std_about_zero, without_spikes
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.inference.fit import colours, fit
from stillarm.diagnosis.inference.fitted import Fit, make_data
from stillarm.diagnosis.inference.impact_doubt import size_of_mode, sizes_in_stds
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]
Series = tuple[Array, Array]
"""Times, s, and a sensor's residual there as deflection, m."""

_FEWEST, _FEWEST_INSTANTS = 50, 10  # samples, and instants to look at, that tell a jump from the usual ones
_HIGHER_PERIODS = (
    6.0  # of a higher mode, before and after an instant: a tenth of a first mode's ringing as a rule
)
_GRID_S = 0.01  # between the instants looked at, unless 2 % of a period are more
_OUTSTANDING = 9.0  # times the median jump: by noise, whose jumps are Rayleigh's, one in 2^81
_NEAR = 5.0  # times the median of those near by: by noise one in 2^25
_FIRST_SHARE, _SHARE = 0.5, 0.25  # of the residual's largest vibration
_LEAST_SHARE = 0.01  # of the arm's largest vibration
_WHILE_SOUGHT = 3  # steps of a fit while impacts are sought: they tell where, not how large
PUSH_PERIODS = 1.6
"""That a push by hand lasts, at most: a longer one swings the arm while it lasts, and is a pull."""
_SAME_S = 0.15  # between an impact and the same one moved
_AGREE = 0.6  # of a jump, by which another sensor may have it otherwise
_NORMAL = 2.0  # times as many medians make a difference of amplitudes, which is normal, as rare as Rayleigh's
_APART_PERIODS = 1.2  # of the first mode, between impacts that one look finds
_MOST = 40  # impacts that one look finds
_SIGNIFICANT = 6.0  # standard deviations of its size: by chance two in a thousand million have it
_CLOSE_S = 2.0  # between impacts of which only the least is dropped at a time


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
            values[known] = without_spikes(values[known])
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


def find_jumps(last: Fit, share: float) -> list[float]:
    """Times, s, at which the vibration jumps by more than `share` of the residual's largest and the usual: the first
    mode's, or while the joint rests a higher one's. An arm that rubs may hide an impact in its first mode alone."""
    found: list[float] = []
    period = 1.0 / last.value("modes.0.frequency_hz")
    jumps = [*_jumps_of_the_first_mode(last, share), *_jumps_of_higher_modes(last, share)]
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


def _jumps_of_the_first_mode(last: Fit, share: float) -> list[tuple[float, float]]:
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
    threshold = np.maximum(usual, max(share * float(np.max(np.abs(after))), swing))
    for other in series[1:]:
        jump[~_borne_out(at, period, w, series[0], other)] = 0.0
    return [(w * w * size, time) for size, time in _largest(jump, threshold, at, _APART_PERIODS * period)]


def _borne_out(at: Array, period: float, w: float, shown: Series, other: Series) -> NDArray[np.bool_]:
    """Whether another sensor shows the same jump: an impact moves the arm, and all that look at it; a sensor that has
    gone wrong moves its own reading. While a push by hand lasts, its force is another jump to each sensor: windows
    before and after it agree. Where the other sensor's noise hides it, it is taken for the same."""
    agree, full = _same_jump(at, period, w, shown, other, 0.0)
    apart, full_apart = _same_jump(at, period, w, shown, other, PUSH_PERIODS / 2.0 * period)
    return agree | ~full | (apart & full_apart)


def _same_jump(
    at: Array, period: float, w: float, shown: Series, other: Series, gap: float
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
    return np.abs(there - jump) < np.maximum(_AGREE * np.abs(jump), 3.0 * usual), full


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


def _refined(last: Fit, number: int) -> float:
    """By how much later the impact number `number` was: a pure jump of the rate leaves the deflection alone, of the
    first mode or, where that is none, of the one that is plainest."""
    sizes = [size_of_mode(last, number, mode) for mode in range(last.world.modes)]
    mode = 0 if sizes[0] > _SIGNIFICANT else int(np.argmax(sizes))
    q, v = last.value(f"jump.{number}.{mode}.q"), last.value(f"jump.{number}.{mode}.v")
    w = 2.0 * pi * last.value(f"modes.{mode}.frequency_hz")
    if v == 0.0:
        return 0.0
    phase = float(np.arctan(w * q / v))
    return -phase / w


def fit_with_impacts(
    world: World, split: Split, start: Array | None = None, reached: Callable[[Fit], None] = lambda one: None
) -> Fit:
    """The baseline's fit, with as many segments as there were impacts. start: vector of the world, if not its own.
    reached: told of the fit with the impacts as they were found, for whoever runs out of time before they are in
    place."""
    sought = with_impacts_sought(world, split, start)
    reached(sought)
    return with_impacts_in_place(sought, split)


def with_impacts_sought(world: World, split: Split, start: Array | None = None) -> Fit:
    """The first half of it: a segment wherever an impact seems to have been."""
    data = make_data(world, split)
    last = fit(data, world.space.vector() if start is None else start, (), iterations=0)
    return _sought(last, split)


def with_impacts_in_place(sought: Fit, split: Split) -> Fit:
    """The second: each impact where it was, and none that was not."""
    last = pruned(sought, split)
    # the noise laws as they are now, rather than as they seemed at the start
    return refit_with(last, split, last.world.impacts)


def _sought(last: Fit, split: Split) -> Fit:
    """Impacts sought in what is left, again and again. last: a start, not a fit."""
    split = replace(split, lends=False)  # what follows a misplaced impact is another's
    impacts: set[int] = set(last.world.impacts)
    for turn in range(5):
        share = _SHARE if turn else _FIRST_SHARE
        cycle_s = last.world.measured.cycle_s
        period = 1.0 / last.value("modes.0.frequency_hz")
        new = {round(t / cycle_s) for t in find_jumps(last, share)}
        new = {k for k in new if all(abs(k - old) * cycle_s > 0.6 * period for old in impacts)}
        if turn and not new:
            break
        impacts |= new
        last = refit_with(last, split, tuple(sorted(impacts)), iterations=_WHILE_SOUGHT)
        last, impacts = _sharpened(last, split)
    return last


def impacts_while_moving(last: Fit) -> list[int]:
    """The impacts within a swing of which the joint was on the move; without those that end what is not judged: from
    there the arm rings from a state of its own, whatever the model says of moves."""
    world = last.world
    reach = round(1.0 / (last.value("modes.0.frequency_hz") * world.measured.cycle_s))
    ends = world.unjudged_ends
    return [
        cycle for cycle in world.impacts if cycle not in ends and not world.measured.rests_about(cycle, reach)
    ]


def refit_with(
    last: Fit, split: Split, impacts: tuple[int, ...], extra: tuple[str, ...] = (), iterations: int = 12
) -> Fit:
    """Fit again with these segments, from what is known."""
    world = last.world.changed(impacts=impacts)
    start = carried_over(last, world)
    free = world.with_baseline(extra)
    data = make_data(world, split)
    return fit(data, start, free, colour=last.colour | colours(data, start), iterations=iterations)


def carried_over(last: Fit, world: World) -> Array:
    """The values of a fit in another world's vector, as far as it has them; each impact's are those of the nearest."""
    start = world.space.vector()
    old = last.world
    cycle_of_old = (0, *old.impacts)
    cycle_of_new = (0, *world.impacts)
    for name, place in world.space.place.items():
        source = name
        if name.startswith("jump."):
            _, j, mode, part = name.split(".")
            cycle = cycle_of_new[int(j)]
            off, nearest = min((abs(other - cycle), k) for k, other in enumerate(cycle_of_old))
            if int(j) == 0:
                nearest = 0
            elif nearest == 0 or off * old.measured.cycle_s > _SAME_S:
                continue
            source = f"jump.{nearest}.{mode}.{part}"
        if source in old.space.place:
            start[place] = last.value(source)
    return start


def _sharpened(last: Fit, split: Split) -> tuple[Fit, set[int]]:
    """Impacts moved to where they leave the deflection without a jump; not those that end what is not judged: the arm
    comes out of that in any state."""
    world = last.world
    cycle_s = world.measured.cycle_s
    ends = world.unjudged_ends
    for _ in range(2):
        moved = []
        for j, cycle in enumerate(world.impacts, start=1):
            shift = min(max(_refined(last, j), -0.12), 0.12) if cycle not in ends else 0.0
            moved.append(min(max(cycle + round(shift / cycle_s), 1), world.measured.cycles - 2))
        moved = sorted(set(moved))
        if tuple(moved) == world.impacts:
            break
        last = refit_with(last, split, tuple(moved), iterations=_WHILE_SOUGHT)
        world = last.world
    return last, set(world.impacts)


def pruned(last: Fit, split: Split) -> Fit:
    """Without the impacts that have turned out to be none; of those close to each other, which may well share one
    impact and each seem needless beside the other, the least goes first, and one that ends what is not judged last:
    between that end and a later one the arm would ring on from a state that nobody judged."""
    near = _CLOSE_S / last.world.measured.cycle_s
    ends = last.world.unjudged_ends
    while True:
        cycles = last.world.impacts
        sizes = [
            np.inf if cycle in ends and any(0 < abs(other - cycle) < near for other in cycles) else size
            for cycle, size in zip(cycles, sizes_in_stds(last), strict=True)
        ]
        kept = tuple(
            cycle
            for cycle, size in zip(cycles, sizes, strict=True)
            if size > _SIGNIFICANT
            or any(
                less < size and abs(other - cycle) < near for other, less in zip(cycles, sizes, strict=True)
            )
        )
        if len(kept) == len(cycles):
            return last
        last = refit_with(last, split, kept)
