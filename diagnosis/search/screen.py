"""Which causes could explain what is left: score tests with the baseline's parameters projected out.

Each trial of each cause gives one or a few directions in which the data would depart. What the residual holds along
them, after the fitted parameters have had their share, predicts the log-likelihood to be gained.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fitted import carried_over
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.forms.cause import Cause, Context, Trial
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.quantities import UNLIMITED
from stillarm.diagnosis.physics.world import Predicted, World
from stillarm.diagnosis.search.whitened import Products, Whitened, best_amounts

Array = NDArray[np.float64]

_ONSETS = (0.15, 0.3, 0.45, 0.6, 0.75)  # of the recording, from which on a trial's directions count alone
_MORE = 1.3  # times what a trial promises throughout: less, and an onset is sought where the whole is fitted
_RUN_AWAY = (
    1e100  # deviations of the noise: of a trial in which the arm runs away, and whose square is no number
)
_MANY = 2  # columns: from there on a prediction of the shape alone spares more than it costs


@dataclass(frozen=True)
class Scored:
    """A trial of a cause. nats: predicted gain. start: vector in its world. begins_s: from when on it acts, of one that
    promises more so than throughout."""

    cause: Cause
    trial: Trial
    nats: float
    world: World
    start: Array
    begins_s: float | None = None


def screen(
    white: Whitened, causes: list[Cause], may_begin: Callable[[Cause], bool] = lambda cause: False
) -> list[Scored]:
    """Score every trial of every form against the fit so far; of each the best three and those that the data ask for,
    the best first. may_begin: whether a cause may act from an instant on alone: of each such the best of those
    trials that promise more so is there too."""
    last = white.last
    context = Context(last, residual_peaks(last))
    onsets_s = [*(np.array(_ONSETS) * last.world.measured.duration_s).tolist(), *white.sets_in_s]
    worlds: dict[tuple[tuple[str, object], ...], tuple[World, Array, Predicted]] = {}
    todo: list[tuple[Cause, Trial]] = []
    for cause in causes:
        if not cause.needs(last.world):
            continue
        for trial in cause.trials(context):
            todo.append((cause, trial))
            if trial.options not in worlds:
                world = variant(last.world, dict(trial.options))
                start = carried_over(last, world)
                worlds[trial.options] = (world, start, world.predict(start))

    def score(one: tuple[Cause, Trial]) -> list[Scored]:
        cause, trial = one
        return _scores(white, cause, trial, worlds[trial.options], onsets_s if may_begin(cause) else ())

    best: dict[int, list[Scored]] = {}
    later: dict[int, Scored] = {}
    known = [*(one for pair in todo for one in pair), *(one[0] for one in worlds.values())]
    for (cause, _), found in zip(todo, shared_out(score, todo, known), strict=True):
        for one in found:
            if one.begins_s is None:
                best.setdefault(id(cause), []).append(one)
            elif id(cause) not in later or one.nats > later[id(cause)].nats:
                later[id(cause)] = one
    scored = list(later.values())
    for of_form in best.values():
        of_form.sort(key=lambda item: -item.nats)
        scored += [*of_form[:3], *(one for one in of_form[3:] if one.trial.asked)]
    return sorted(scored, key=lambda item: -item.nats)


def variant(world: World, options: dict[str, object]) -> World:
    """The same recording in a world of other structure."""
    extra, behind = options.get("extra_modes", 0), options.get("behind_encoder", world.behind_encoder)
    assert isinstance(extra, int) and isinstance(behind, bool)
    return world.changed(extra_modes=world.extra_modes + extra, behind_encoder=behind)


def _scores(
    white: Whitened,
    cause: Cause,
    trial: Trial,
    at: tuple[World, Array, Predicted],
    onsets_s: Sequence[float],
) -> list[Scored]:
    """A trial throughout; and from the best of some instants on, if that promises more."""
    world, start, base = at
    shaped = world.space.with_values(start, trial.shape)
    near = world.predict(world.space.clipped(shaped), base) if len(trial.columns) > _MANY else base
    d = np.empty((len(white.residual), len(trial.columns)), order="F")
    for index, column in enumerate(trial.columns):
        moved = world.space.with_values(shaped, column)
        white.weighted(world.predict(world.space.clipped(moved), near), base, d[:, index])
    if not np.max(np.abs(d), initial=0.0) < _RUN_AWAY:  # nor NaN
        return []
    onsets_s = () if trial.asked else onsets_s
    of_all, *from_there = white.products(d, onsets_s)
    throughout = _promised(white, of_all, trial)
    later = None
    for begins_s, products in zip(onsets_s, from_there, strict=True):
        promised = _promised(white, products, trial)
        if promised is not None and (later is None or promised[0] > later[0]):
            later = (*promised, begins_s)
    found = []
    if throughout is not None:
        nats, amounts = throughout
        found.append(Scored(cause, trial, nats, world, _begun(cause, trial, world, start, shaped, amounts)))
    elif trial.asked:
        found.append(_unseen(cause, trial, world, shaped))
    if later is not None and later[0] > _MORE * max(throughout[0] if throughout else 0.0, 0.0):
        nats, amounts, begins_s = later
        begun = _begun(cause, trial, world, start, shaped, amounts)
        found.append(Scored(cause, trial, nats, world, begun, begins_s))
    return found


def _promised(white: Whitened, products: Products, trial: Trial) -> tuple[float, Array] | None:
    """Predicted gain by a trial's directions, and their amounts, (k,); None where they show nothing, or would have to
    be negative."""
    amounts = best_amounts(products)
    if amounts is None or (trial.one_sided and amounts[0] <= 0.0 and not trial.asked):
        return None
    return white.gain(products, amounts), amounts


def _begun(cause: Cause, trial: Trial, world: World, start: Array, shaped: Array, amounts: Array) -> Array:
    """Where a fit of a trial begins: by these amounts of its columns."""
    begun = shaped.copy()
    for column, amount in zip(trial.columns, amounts, strict=True):
        bounded = min(max(amount, 0.3), 2.5) if trial.one_sided else amount
        for name, value in column.items():
            place = world.space.place[name]
            whole = abs(start[place]) >= UNLIMITED  # no share of the way from no limit to one is a limit
            begun[place] = value if whole else start[place] + bounded * (value - start[place])
    if trial.exact or (trial.one_sided and cause.settle):  # a threshold: its value is the trial's own
        begun = world.space.with_values(begun, trial.columns[0])
    return world.space.clipped(begun)


def _unseen(cause: Cause, trial: Trial, world: World, shaped: Array) -> Scored:
    """A trial that the data ask for, and that changes nothing that trains: from its own values."""
    start = shaped
    for column in trial.columns:
        start = world.space.with_values(start, column)
    return Scored(cause, trial, 0.0, world, world.space.clipped(start))
