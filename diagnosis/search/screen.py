"""Which causes could explain what is left: score tests with the baseline's parameters projected out.

Each trial of each cause gives one or a few directions in which the data would depart. What the residual holds along
them, after the fitted parameters have had their share, predicts the log-likelihood to be gained.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import HUBER
from stillarm.diagnosis.fitting.departures import sets_in_s
from stillarm.diagnosis.fitting.fit import Slopes, jacobian, whitened
from stillarm.diagnosis.fitting.fitted import (
    THIN,
    Data,
    Fit,
    carried_over,
    least_level,
    thinned,
    thinned_mask,
)
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.forms.cause import Cause, Context, Trial
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.quantities import ARRIVAL, UNLIMITED
from stillarm.diagnosis.physics.world import Predicted, World

Array = NDArray[np.float64]

_ONSETS = (0.15, 0.3, 0.45, 0.6, 0.75)  # of the recording, from which on a trial's directions count alone
_MORE = 1.3  # times what a trial promises throughout: less, and an onset is sought where the whole is fitted
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


class Whitened:
    """The training residual as one vector, the baseline's directions taken out of whatever is asked."""

    def __init__(self, data: Data, last: Fit, slopes: Slopes) -> None:
        """slopes: of the fit (stillarm.diagnosis.fitting.fit.slopes_of)."""
        self.data, self.last = data, last
        self.sets_in_s = sets_in_s(last)
        self.weights: dict[str, Array] = {}
        parts, times, self.spans = [], [], {}
        self._masks = {name: thinned_mask(name, data.train[name]) for name in last.residuals}
        at = 0
        for name, residual in last.residuals.items():
            std = last.sigma[name] / THIN.get(name, 1) ** 0.5
            u = thinned(name, residual)[self._masks[name]] / std
            tail = np.sqrt(np.minimum(1.0, HUBER / np.maximum(np.abs(u), 1e-12)))
            self.weights[name] = tail / std
            parts.append(u * tail)
            times.append(thinned(name, data.world.times_of(name)[: len(residual)])[self._masks[name]])
            self.spans[name] = slice(at, at + len(u))
            at += len(u)
        self.residual, self.time_s = np.concatenate(parts), np.concatenate(times)
        # A part of a cycle is all that it may be: as a direction it would explain a dead time of any length. Nor is a
        # bound that the fit came to a direction, such as the most that two sound clocks differ by.
        inside = last.world.space.within_bounds
        names = [name for name in last.free if name != ARRIVAL and inside(name, last.vector)]
        by = jacobian(last.world, last.vector, names, last.predicted, last.colour, slopes)
        stacked = np.concatenate([by[n][self._masks[n]] * self.weights[n][:, None] for n in by])
        norms = np.linalg.norm(stacked, axis=0)
        keep = norms > 1e-12
        scaled = stacked[:, keep] / norms[keep]
        # an orthonormal basis by the eigenvectors of the small Gram matrix
        values, vectors = np.linalg.eigh(scaled.T @ scaled)
        good = values > 1e-9 * values[-1] if len(values) else np.empty(0, bool)
        self.basis = np.asfortranarray(scaled @ (vectors[:, good] / np.sqrt(values[good])))
        self.residual = self.residual - self.basis @ (self.basis.T @ self.residual)

    def weighted(self, predicted: Predicted, base: Predicted, out: Array) -> None:
        """Fill in how a prediction differs from another, weighted as the residual is, (samples,)."""
        for name, span in self.spans.items():
            if predicted.channels[name] is base.channels[name]:
                out[span] = 0.0
                continue
            out[span] = self._of_channel(name, predicted.channels[name] - base.channels[name])

    def _of_channel(self, name: str, change: Array) -> Array:
        """A channel's change, weighted as its residual is."""
        return whitened(name, change, self.last.colour)[self._masks[name]] * self.weights[name]

    def promise(self, columns: Mapping[str, Array]) -> float:
        """Log-likelihood that terms promise which are added to channels in any amounts. columns: by channel, (samples,
        k)."""
        k = next(iter(columns.values())).shape[1]
        d = np.zeros((len(self.residual), k), order="F")
        for name, values in columns.items():
            for place in range(k):
                d[self.spans[name], place] = self._of_channel(name, values[:, place])
        self.without_baseline(d)
        d /= np.maximum(np.linalg.norm(d, axis=0), 1e-300)
        basis = _orthonormal(d)
        return self.gain(d @ (basis @ (basis.T @ (d.T @ self.residual))))

    def foretold(self, world: World, base: Predicted, start: Array) -> float:
        """Log-likelihood gained by what a vector of a world changes, as it is, the baseline making up for what it can.
        base: what the world shows at the fit."""
        change = np.empty((len(self.residual), 1), order="F")
        self.weighted(world.predict(world.space.clipped(start), base), base, change[:, 0])
        self.without_baseline(change)
        return self.gain(change[:, 0])

    def without_baseline(self, changes: Array) -> None:
        """Take the baseline's directions out of changes, (samples, k), in place."""
        size = np.einsum("ij,ij->j", changes, changes)
        for _ in range(2):  # again where rounding may exceed what the first time leaves
            shares = self.basis.T @ changes
            changes -= (shares.T @ self.basis.T).T  # in the order in which both lie in memory
            if (np.einsum("ij,ij->j", changes, changes) >= 1e-6 * size).all():
                break

    def gain(self, explained: Array) -> float:
        """Log-likelihood gained by taking `explained` off the residual, each channel's level learnt anew."""
        total = 0.0
        for name, span in self.spans.items():
            rest = self.residual[span] - explained[span]
            least = (least_level(self.last.world, name) / self.last.sigma[name]) ** 2
            total += _profile(rest, least) - _profile(self.residual[span], least)
        return total


def _profile(residual: Array, least: float) -> float:
    """Log-likelihood of a whitened residual at its own level, which is not below `least` (variance)."""
    n = len(residual)
    power = float(residual @ residual)
    variance = max(power / max(n, 1), least, 1e-30)
    return -0.5 * n * float(np.log(variance)) - 0.5 * power / variance


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
    if not np.isfinite(d).all():
        return []
    later = _later(white, d, trial, onsets_s) if onsets_s and not trial.asked else None
    white.without_baseline(d)
    throughout = _promised(white, d, trial)
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


def _later(
    white: Whitened, d: Array, trial: Trial, onsets_s: Sequence[float]
) -> tuple[float, Array, float] | None:
    """What directions promise that count from an instant on alone, for the best instant: about that of the cause that
    acts from then on, but for a swing or two in which it sets in. Leaves the directions as they are."""
    k = d.shape[1]
    parts = np.empty((len(d), k * len(onsets_s)), order="F")
    for i, begins_s in enumerate(onsets_s):
        np.multiply(d, (white.time_s >= begins_s)[:, None], out=parts[:, k * i : k * (i + 1)])
    white.without_baseline(parts)  # of all at once: what takes the time is to read the baseline's directions
    best = None
    for i, begins_s in enumerate(onsets_s):
        found = _promised(white, parts[:, k * i : k * (i + 1)], trial)
        if found is not None and (best is None or found[0] > best[0]):
            best = (*found, begins_s)
    return best


def _promised(white: Whitened, d: Array, trial: Trial) -> tuple[float, Array] | None:
    """Predicted gain by directions without the baseline's, (samples, k), and their amounts, (k,); None where they show
    nothing, or would have to be negative. Makes them unit vectors in place."""
    norms = np.linalg.norm(d, axis=0)
    seen = norms > 1e-6
    if not seen.any():
        return None
    d = d if seen.all() else d[:, seen]
    d /= norms[seen]
    basis = _orthonormal(d)
    share = basis.T @ (d.T @ white.residual)
    amounts = np.zeros(len(norms))
    amounts[seen] = basis @ share / norms[seen]
    if trial.one_sided and amounts[0] <= 0.0 and not trial.asked:
        return None
    return white.gain(d @ (basis @ share)), amounts


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


def _orthonormal(d: Array) -> Array:
    """Amounts of directions of length 1, d, (samples, k), in an orthonormal basis, which is d @ them."""
    values, vectors = np.linalg.eigh(d.T @ d)
    found: Array = vectors[:, values > 1e-8] / np.sqrt(values[values > 1e-8])
    return found


def _unseen(cause: Cause, trial: Trial, world: World, shaped: Array) -> Scored:
    """A trial that the data ask for, and that changes nothing that trains: from its own values."""
    start = shaped
    for column in trial.columns:
        start = world.space.with_values(start, column)
    return Scored(cause, trial, 0.0, world, world.space.clipped(start))
