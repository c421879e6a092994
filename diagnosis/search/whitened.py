"""The training residual as one vector, and what directions hold of it with the baseline's own taken out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import HUBER
from stillarm.diagnosis.fitting.departures import sets_in_s
from stillarm.diagnosis.fitting.fit import Slopes, jacobian, whitened
from stillarm.diagnosis.fitting.fitted import THIN, Data, Fit, least_level, thinned, thinned_mask
from stillarm.diagnosis.physics.quantities import ARRIVAL
from stillarm.diagnosis.physics.world import Predicted, World

Array = NDArray[np.float64]

_SEEN = 1e-6  # length of a direction, in units of the noise of one sample, that changes anything
_AT_ONCE = 16  # directions that the baseline's share is taken out of: each step holds as much once more
_ROUNDED = 1e-9  # of a direction's square: less is left by the baseline, and rounding has a part in it


@dataclass(frozen=True)
class Products:
    """Inner products of k directions, channel by channel: all that a score test asks of them, however long they are.

    own: with one another, (channels, k, k). baseline: with the n directions of the baseline, (channels, n, k).
    residual: with the residual, (channels, k).
    """

    own: Array
    baseline: Array
    residual: Array

    def without_baseline(self) -> Array:
        """Inner products with one another, the baseline's directions taken out, (k, k)."""
        shared = self.baseline.sum(axis=0)
        left: Array = self.own.sum(axis=0) - shared.T @ shared
        return left


class Whitened:
    """The training residual as one vector, the baseline's directions taken out of whatever is asked."""

    def __init__(self, data: Data, last: Fit, slopes: Slopes) -> None:
        """slopes: of the fit (stillarm.diagnosis.fitting.fit.slopes_of)."""
        self.last = last
        self.sets_in_s = sets_in_s(last)
        self.weights: dict[str, Array] = {}
        parts, self.spans = [], {}
        self.times_s: dict[str, Array] = {}
        self._masks = {name: thinned_mask(name, data.train[name]) for name in last.residuals}
        at = 0
        for name, residual in last.residuals.items():
            std = last.sigma[name] / THIN.get(name, 1) ** 0.5
            u = thinned(name, residual)[self._masks[name]] / std
            tail = np.sqrt(np.minimum(1.0, HUBER / np.maximum(np.abs(u), 1e-12)))
            self.weights[name] = tail / std
            parts.append(u * tail)
            times = thinned(name, data.world.times_of(name)[: len(residual)])[self._masks[name]]
            self.times_s[name] = np.maximum.accumulate(times)  # images may overtake one another
            self.spans[name] = slice(at, at + len(u))
            at += len(u)
        self.basis = self._directions(slopes)
        residual = np.concatenate(parts)
        self.residual = residual - self.basis @ (self.basis.T @ residual)
        by = self.spans.values()
        self._power = np.array([float(self.residual[span] @ self.residual[span]) for span in by])
        self._least = np.array(
            [(least_level(last.world, name) / last.sigma[name]) ** 2 for name in self.spans]
        )
        self._count = np.array([span.stop - span.start for span in by])
        self._basis_own = np.array([self.basis[span].T @ self.basis[span] for span in by])
        self._basis_residual = np.array([self.basis[span].T @ self.residual[span] for span in by])

    def _directions(self, slopes: Slopes) -> Array:
        """An orthonormal basis of what the fit's free parameters change, (samples, n)."""
        last = self.last
        # A part of a cycle is all that it may be: as a direction it would explain a dead time of any length. Nor is a
        # bound that the fit came to a direction, such as the most that two sound clocks differ by.
        inside = last.world.space.within_bounds
        names = [name for name in last.free if name != ARRIVAL and inside(name, last.vector)]
        by = jacobian(last.world, last.vector, names, last.predicted, last.colour, slopes)
        stacked = np.concatenate([by[n][self._masks[n]] * self.weights[n][:, None] for n in by])
        norms = np.linalg.norm(stacked, axis=0)
        basis: Array = stacked[:, norms > 1e-12] / norms[norms > 1e-12]
        for _ in range(2):  # again, as the small Gram matrix squares how nearly parallel two of them are
            basis = np.asfortranarray(basis @ orthonormal(basis.T @ basis, 1e-9))
        return basis

    def weighted(self, predicted: Predicted, base: Predicted, out: Array) -> None:
        """Fill in how a prediction differs from another, weighted as the residual is, (samples,)."""
        for name, span in self.spans.items():
            if predicted.channels[name] is base.channels[name]:
                out[span] = 0.0
                continue
            out[span] = self._of_channel(name, predicted.channels[name] - base.channels[name])

    def _of_channel(self, name: str, change: Array) -> Array:
        """A channel's change, weighted as its residual is."""
        alike: Array = whitened(name, change, self.last.colour)[self._masks[name]] * self.weights[name]
        return alike

    def products(self, d: Array, onsets_s: Sequence[float] = ()) -> list[Products]:
        """Inner products of directions d, (samples, k): throughout, and from each of some instants on alone.

        They are summed once over the time between one instant and the next, as the baseline's directions are by far the
        most to read.
        """
        edges_s = sorted(set(onsets_s))
        many, n, k = (len(edges_s) + 1, len(self.spans)), self.basis.shape[1], d.shape[1]
        parts = Products(np.zeros((*many, k, k)), np.zeros((*many, n, k)), np.zeros((*many, k)))
        for channel, (name, span) in enumerate(self.spans.items()):
            inner = (span.start + np.searchsorted(self.times_s[name], edges_s)).tolist()
            edges = [span.start, *inner, span.stop]
            for part, (start, end) in enumerate(pairwise(edges)):
                own = d[start:end]
                squares = own.T @ own
                if not squares.any():
                    continue
                parts.own[part, channel] = squares
                parts.baseline[part, channel] = self.basis[start:end].T @ own
                parts.residual[part, channel] = self.residual[start:end] @ own
        from_there = _from_each_on(parts)
        places = [0, *(edges_s.index(begins_s) + 1 for begins_s in onsets_s)]
        return [self._exact(from_there[place], d, edges_s[place - 1] if place else None) for place in places]

    def _exact(self, products: Products, d: Array, begins_s: float | None) -> Products:
        """Products whose directions the baseline leaves enough of; of the directions with the baseline's share taken
        out where rounding may exceed what it leaves."""
        squares = np.diagonal(products.own.sum(axis=0))
        if (np.diagonal(products.without_baseline()) >= _ROUNDED * squares).all():
            return products
        d = d.copy(order="F")
        for name, span in self.spans.items():
            if begins_s is not None:
                d[span][self.times_s[name] < begins_s] = 0.0
        for first in range(0, d.shape[1], _AT_ONCE):
            some = d[:, first : first + _AT_ONCE]
            for _ in range(2):  # again where rounding may exceed what the first time leaves
                some -= self.basis @ (self.basis.T @ some)
        own, residual = np.empty_like(products.own), np.empty_like(products.residual)
        for channel, span in enumerate(self.spans.values()):
            own[channel], residual[channel] = d[span].T @ d[span], self.residual[span] @ d[span]
        return Products(own, np.zeros_like(products.baseline), residual)

    def promise(self, columns: Mapping[str, Array]) -> float:
        """Log-likelihood that terms promise which are added to channels in any amounts. columns: by channel, (samples,
        k)."""
        k = next(iter(columns.values())).shape[1]
        d = np.zeros((len(self.residual), k), order="F")
        for name, values in columns.items():
            for place in range(k):
                d[self.spans[name], place] = self._of_channel(name, values[:, place])
        (products,) = self.products(d)
        amounts = best_amounts(products)
        return 0.0 if amounts is None else self.gain(products, amounts)

    def foretold(self, world: World, base: Predicted, start: Array) -> float:
        """Log-likelihood gained by what a vector of a world changes, as it is, the baseline making up for what it can.
        base: what the world shows at the fit."""
        change = np.empty((len(self.residual), 1), order="F")
        self.weighted(world.predict(world.space.clipped(start), base), base, change[:, 0])
        (products,) = self.products(change)
        return self.gain(products, np.ones(1))

    def gain(self, products: Products, amounts: Array) -> float:
        """Log-likelihood gained by taking directions in these amounts, (k,), off the residual, without the baseline's
        share, each channel's level learnt anew."""
        by_channel = products.baseline @ amounts
        taken = by_channel.sum(axis=0)
        with_residual = products.residual @ amounts - self._basis_residual @ taken
        own = products.own @ amounts @ amounts - 2.0 * by_channel @ taken + self._basis_own @ taken @ taken
        power = np.maximum(self._power - 2.0 * with_residual + own, 0.0)
        return float((self._profile(power) - self._profile(self._power)).sum())

    def _profile(self, power: Array) -> Array:
        """Log-likelihood of each channel's whitened residual at its own level, which is not below `_least` (variance).
        power: sum of squares, (channels,)."""
        variance = np.maximum(np.maximum(power / np.maximum(self._count, 1), self._least), 1e-30)
        likelihood: Array = -0.5 * self._count * np.log(variance) - 0.5 * power / variance
        return likelihood


def _from_each_on(parts: Products) -> list[Products]:
    """Of each part of the time and all that follow it. parts: inner products of each alone, (parts, channels, ...)."""
    summed = [one[::-1].cumsum(axis=0)[::-1] for one in (parts.own, parts.baseline, parts.residual)]
    return [Products(*one) for one in zip(*summed, strict=True)]


def best_amounts(products: Products) -> Array | None:
    """Amounts of directions that explain most of the residual, (k,); None where the baseline leaves none of them."""
    left, along = products.without_baseline(), products.residual.sum(axis=0)
    if len(along) == 1:
        return along / left[0] if left[0, 0] > _SEEN * _SEEN else None
    norms = np.sqrt(np.maximum(np.diagonal(left), 0.0))
    seen = norms > _SEEN
    if not seen.any():
        return None
    basis = orthonormal(left[np.ix_(seen, seen)] / np.outer(norms[seen], norms[seen]), 1e-8)
    amounts = np.zeros(len(norms))
    share = along[seen] / norms[seen]
    amounts[seen] = basis @ (basis.T @ share) / norms[seen]
    return amounts


def orthonormal(gram: Array, least: float) -> Array:
    """Amounts of directions of length 1 that make an orthonormal basis of them. gram: their inner products, (k, k).
    least: eigenvalue, over the greatest, below which a direction is none of its own."""
    if not len(gram):
        return gram
    values, vectors = np.linalg.eigh(gram)
    good = values > least * values[-1]
    found: Array = vectors[:, good] / np.sqrt(values[good])
    return found
