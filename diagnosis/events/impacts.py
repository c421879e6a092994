"""Impacts that no sensor measured: where the free vibration's phasor jumps (jumps.py), a new segment begins with a
state of its own; it is moved to where it leaves the deflection without a jump, and dropped if it turns out to be none.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import pi

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impact_departure import departs_at
from stillarm.diagnosis.events.impact_doubt import doubts_about_modes, size_of_mode, sizes_in_stds
from stillarm.diagnosis.events.jumps import find_jumps
from stillarm.diagnosis.fitting.fit import colours, fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_FIRST_SHARE, _SHARE = 0.5, 0.25  # of the residual's largest vibration
WHILE_SOUGHT, ANEW = 4, 2
"""Steps of a fit while impacts are sought: they tell where, not how large. Those that work out derivatives."""
_SIGNIFICANT = 6.0  # standard deviations of its size: by chance two in a thousand million have it
_CLOSE_S = 2.0  # between impacts of which only the least is dropped at a time


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


def with_impacts_sought(
    world: World,
    split: Split,
    start: Array | None = None,
    extra: tuple[str, ...] = (),
    hopeless: Callable[[Fit], bool] = lambda one: False,
) -> Fit:
    """The first half of it: a segment wherever an impact seems to have been. extra: what is fitted beside the
    baseline's quantities, here and in the second half. hopeless: of a fit on the way, whether to look no further."""
    data = make_data(world, split)
    last = fit(data, world.space.vector() if start is None else start, extra, iterations=0)
    return _sought(last, split, hopeless)


def with_impacts_in_place(sought: Fit, split: Split) -> Fit:
    """The second: each impact where it was, and none that was not."""
    # by the noise laws as they are now, rather than as they seemed at the start, and by the samples just after each
    # impact, which the search left alone: the ringing of a stiff arm is over within a block that is held out
    return pruned(refit_with(sought, split, sought.world.impacts), split)


def with_further_impacts(last: Fit, split: Split) -> Fit:
    """A fit, whatever it frees beside the baseline's quantities, with the impacts that show in what it leaves."""
    return with_impacts_in_place(_sought(last, split), split)


def _sought(last: Fit, split: Split, hopeless: Callable[[Fit], bool] = lambda one: False) -> Fit:
    """Impacts sought in what is left, again and again. last: a start, or a fit. hopeless: as in
    `with_impacts_sought`."""
    split = replace(split, lends=False)  # what follows a misplaced impact is another's
    impacts: set[int] = set(last.world.impacts)
    for turn in range(5):
        share = _SHARE if turn else _FIRST_SHARE
        new = _new_impacts(last, share, impacts)
        if impacts and not new:
            new = _new_impacts(last, share, impacts, elsewhere=True)
        if turn and not new:
            break
        impacts |= new
        last = refit_with(last, split, tuple(sorted(impacts)), iterations=WHILE_SOUGHT, anew=ANEW)
        if hopeless(last):
            break
        last, impacts = _sharpened(last, split)
    return last


def _new_impacts(last: Fit, share: float, known: set[int], elsewhere: bool = False) -> set[int]:
    """The cycles at which the vibration jumps and no impact is known. share, elsewhere: as in `find_jumps`."""
    cycle_s, period = last.world.measured.cycle_s, 1.0 / last.value("modes.0.frequency_hz")
    cycles = {round(t / cycle_s) for t in find_jumps(last, share, elsewhere)}
    return {one for one in cycles if all(abs(one - old) * cycle_s > 0.6 * period for old in known)}


def needs_more(last: Fit, other: Fit) -> bool:
    """Whether a fit is the less likely one with no fewer impacts."""
    fewer = len(last.world.impacts) < len(other.world.impacts)
    return not fewer and last.train_log_likelihood < other.train_log_likelihood


def impacts_while_moving(last: Fit) -> list[int]:
    """The impacts within a swing of which the joint was on the move; without those that a better model bears out, those
    that end what is not judged, from where the arm rings from a state of its own, whatever the model says of moves, and
    those that the accelerometer shows before the move: what is wrong about that departs later."""
    world = last.world
    reach = round(1.0 / (last.value("modes.0.frequency_hz") * world.measured.cycle_s))
    known = world.unjudged_ends | world.borne_out
    return [
        cycle
        for cycle in world.impacts
        if cycle not in known
        and not world.measured.rests_about(cycle, reach)
        and not _departs_at_rest(last, cycle, reach)
    ]


def _departs_at_rest(last: Fit, cycle: int, reach: int) -> bool:
    """Whether an impact shows while the joint rests, and has rested for so many cycles; no where there is no time left
    to tell."""
    try:
        onset = departs_at(last, cycle)
    except OutOfTime:
        return False
    return onset is not None and not last.world.measured.told_to_move[max(onset - reach, 0) : onset].any()


def without_impacts_while_moving(last: Fit) -> World:
    """The fit's world without them. The accelerometer is judged about their strokes as little as before."""
    doubtful, world = impacts_while_moving(last), last.world
    kept = tuple(cycle for cycle in world.impacts if cycle not in doubtful)
    return world.changed(impacts=kept, strokes=world.strokes)


def refit_with(
    last: Fit,
    split: Split,
    impacts: tuple[int, ...],
    extra: tuple[str, ...] = (),
    iterations: int = 12,
    anew: int | None = None,
) -> Fit:
    """Fit again with these segments, from what is known. extra: freed beside what is free already. anew: as in
    `fit`."""
    world = last.world.changed(impacts=impacts)
    start = carried_over(last, world)
    kept = (name for name in last.free if not name.startswith("jump."))
    free = tuple(dict.fromkeys((*world.with_baseline(extra), *kept)))
    data = make_data(world, split)
    colour = last.colour | colours(data, start)
    return fit(data, start, free, colour=colour, iterations=iterations, anew=anew)


def _sharpened(last: Fit, split: Split) -> tuple[Fit, set[int]]:
    """Impacts moved to where they leave the deflection without a jump; not those that end what is not judged: the arm
    comes out of that in any state."""
    world = last.world
    cycle_s = world.measured.cycle_s
    known = world.unjudged_ends | world.borne_out
    for _ in range(2):
        moved = []
        for j, cycle in enumerate(world.impacts, start=1):
            shift = min(max(_refined(last, j), -0.12), 0.12) if cycle not in known else 0.0
            moved.append(min(max(cycle + round(shift / cycle_s), 1), world.measured.cycles - 2))
        moved = sorted(set(moved))
        if tuple(moved) == world.impacts:
            break
        last = refit_with(last, split, tuple(moved), iterations=WHILE_SOUGHT, anew=ANEW)
        world = last.world
    return last, set(world.impacts)


def pruned(last: Fit, split: Split) -> Fit:
    """Without the impacts that have turned out to be none."""
    while True:
        kept = _significant(last)
        if len(kept) == len(last.world.impacts):
            return last
        last = refit_with(last, split, kept)


def _significant(last: Fit) -> tuple[int, ...]:
    """The impacts that stay where those that are none are dropped, as far as a fit tells without another one: to first
    order what a fit makes of the rest, once a jump is nothing, is the conditional mean of a normal distribution. Of
    those close to each other, which may well share one impact and each seem needless beside the other, the least goes
    first, and one that ends what is not judged last: between that end and a later one the arm would ring on from a
    state that nobody judged."""
    near = _CLOSE_S / last.world.measured.cycle_s
    ends, kept, here = last.world.unjudged_ends, last.world.impacts, last
    doubts = doubts_about_modes(last)  # what it leaves stays as it is
    while True:
        sizes = {
            cycle: np.inf
            if cycle in last.world.borne_out
            or (cycle in ends and any(0 < abs(other - cycle) < near for other in kept))
            else size
            for cycle, size in zip(last.world.impacts, sizes_in_stds(here, doubts), strict=True)
            if cycle in kept
        }
        stay = tuple(
            cycle
            for cycle, size in sizes.items()
            if size > _SIGNIFICANT
            or any(less < size and abs(other - cycle) < near for other, less in sizes.items())
        )
        if len(stay) == len(kept):
            return kept
        here = _without_jumps(here, [cycle for cycle in kept if cycle not in stay])
        kept = stay


def _without_jumps(last: Fit, cycles: Sequence[int]) -> Fit:
    """Values and deviations of a fit where the jumps of some impacts are none, to first order."""
    numbers = {str(1 + last.world.impacts.index(cycle)) for cycle in cycles}
    gone = np.array([name.startswith("jump.") and name.split(".")[1] in numbers for name in last.free])
    places = np.array([last.world.space.place[name] for name in last.free])
    covariance = last.covariance
    follow = covariance[:, gone] @ np.linalg.pinv(covariance[np.ix_(gone, gone)], hermitian=True)
    vector = last.vector.copy()
    vector[places] -= follow @ vector[places[gone]]
    vector[places[gone]] = 0.0
    covariance = covariance - follow @ covariance[gone]
    covariance[gone] = covariance[:, gone] = 0.0
    variances = np.maximum(np.diag(covariance), 0.0)
    std = dict(zip(last.free, np.sqrt(variances).tolist(), strict=True))
    return replace(last, vector=vector, std=std, covariance=covariance)
