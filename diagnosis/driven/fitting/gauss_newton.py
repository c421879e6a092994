"""The algebra of a Gauss-Newton step: each block's state projected out, numbers within their bounds.

Variable projection: Golub and Pereyra, SIAM J. Numerical Analysis 10, 1973.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.bounds import within
from stillarm.diagnosis.driven.greybox.greybox import GreyBox

Array = NDArray[np.float64]
RIDGE = 1e-9
"""On the diagonal, so that a number which nothing shows leaves the equations solvable."""

_STOPPED = 1e-9  # of a step: less is rounding
_MADE_UP = 1e-7  # of a column's length, beside the others: less is rounding


@dataclass(frozen=True, eq=False)
class Piece:
    """Of a block: derivatives by the numbers, (n, p), and by its state, (n, q), what is left, and whether it trains.

    All that follows asks of a block's samples is worked out once.
    """

    by_numbers: Array
    by_state: Array
    left: Array
    trains: bool

    @cached_property
    def _size(self) -> Array:
        size = np.linalg.norm(self.by_state, axis=0)
        return np.where(size > 0.0, size, 1.0)

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        q, r = np.linalg.qr(self.by_state / self._size)
        return q, r

    @cached_property
    def basis(self) -> Array:
        """Of what the state can make, orthonormal; without what its other components make up."""
        q, r = self._factors
        kept = np.abs(np.diag(r)) > _MADE_UP
        return q if kept.all() else np.asarray(q[:, kept])

    @cached_property
    def free(self) -> tuple[Array, Array]:
        """Derivatives by the numbers and what is left, without what the state can make of them."""
        q, j, r = self.basis, self.by_numbers, self.left
        return j - q @ (q.T @ j), r - q @ (q.T @ r)

    @cached_property
    def _seen(self) -> tuple[Array, Array]:
        q, _ = self._factors
        return q.T @ self.by_numbers, q.T @ self.left

    @property
    def most_gain(self) -> float:
        """By how much another state may lessen the sum of squares, to first order."""
        return float(np.sum((self.basis.T @ self.left) ** 2)) if len(self.left) else 0.0

    def state_step(self, step: Array) -> Array:
        """What the state moves by where the numbers move by `step`."""
        if not len(self.left):
            return np.zeros(self.by_state.shape[1])
        by_numbers, left = self._seen
        # the factor has the singular values of the derivatives themselves
        moved = np.linalg.lstsq(self._factors[1], left - by_numbers @ step, rcond=1e-6)[0]
        return np.asarray(moved / self._size)


def stepped(
    box: GreyBox, numbers: dict[str, float], free: tuple[str, ...], normal: Array, gradient: Array
) -> tuple[dict[str, float], Array]:
    """Numbers after a step within their bounds, and what each has moved. Those that a bound stops stay there, and the
    others step as suits that: a step that counts on a number beyond its bound leads astray."""
    step: Array = np.asarray(np.linalg.solve(normal, gradient), np.float64)
    trial = within({**numbers, **{n: numbers[n] + d for n, d in zip(free, step, strict=True)}}, box)
    moved = np.array([trial[name] - numbers[name] for name in free], np.float64)
    stopped = np.abs(moved - step) > _STOPPED * np.abs(step)
    if stopped.any() and not stopped.all():
        goes = ~stopped
        rest = gradient[goes] - normal[np.ix_(goes, stopped)] @ moved[stopped]
        step = moved.copy()
        step[goes] = np.linalg.solve(normal[np.ix_(goes, goes)], rest)
        trial = within({**numbers, **{n: numbers[n] + d for n, d in zip(free, step, strict=True)}}, box)
        moved = np.array([trial[name] - numbers[name] for name in free], np.float64)
    return trial, moved


def normal_of(pieces: list[Piece], count: int) -> tuple[Array, Array]:
    """Normal matrix and gradient of the numbers, of the blocks that train, without what the blocks' states can make."""
    normal, gradient = np.zeros((count, count)), np.zeros(count)
    for one in pieces:
        if not one.trains or not len(one.left):
            continue
        by_numbers, left = one.free
        normal += by_numbers.T @ by_numbers
        gradient += by_numbers.T @ left
    return normal, gradient


def orthonormal(k: Array) -> Array:
    """A basis of what the columns span, (n, at most m); without those that the others make up."""
    size = np.linalg.norm(k, axis=0)
    q, r = np.linalg.qr(k / np.where(size > 0.0, size, 1.0))
    return np.asarray(q[:, np.abs(np.diag(r)) > _MADE_UP])


def state_steps(pieces: list[Piece], step: Array) -> Array:
    """What each block's state moves by where the numbers move by `step`, (blocks, size)."""
    return np.array([one.state_step(step) for one in pieces])
