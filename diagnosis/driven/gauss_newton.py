"""The algebra of a Gauss-Newton step: each block's state projected out, numbers within their bounds.

Variable projection: Golub and Pereyra, SIAM J. Numerical Analysis 10, 1973.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.bounds import within
from stillarm.diagnosis.driven.greybox import GreyBox

Array = NDArray[np.float64]
RIDGE = 1e-9
"""On the diagonal, so that a number which nothing shows leaves the equations solvable."""

_STOPPED = 1e-9  # of a step: less is rounding

Piece = tuple[Array, Array, Array, bool]
"""Of a block: derivatives by the numbers and by its state, residual, and whether it trains."""


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
    for j, k, r, trains in pieces:
        if not trains or not len(r):
            continue
        q = orthonormal(k)
        j_free, r_free = j - q @ (q.T @ j), r - q @ (q.T @ r)
        normal += j_free.T @ j_free
        gradient += j_free.T @ r_free
    return normal, gradient


def orthonormal(k: Array) -> Array:
    """A basis of what the columns span, (n, at most m); without those that the others make up."""
    size = np.linalg.norm(k, axis=0)
    q, r = np.linalg.qr(k / np.where(size > 0.0, size, 1.0))
    kept = np.abs(np.diag(r)) > 1e-7
    return np.asarray(q[:, kept])


def state_steps(pieces: list[Piece], step: Array) -> Array:
    """What each block's state moves by where the numbers move by `step`, (blocks, size)."""
    rows = []
    for j, k, r, _ in pieces:
        size = np.linalg.norm(k, axis=0)
        size = np.where(size > 0.0, size, 1.0)
        left = r - j @ step
        rows.append(np.linalg.lstsq(k / size, left, rcond=1e-6)[0] / size if len(r) else np.zeros(k.shape[1]))
    return np.array(rows)
