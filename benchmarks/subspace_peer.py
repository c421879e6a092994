"""A plain linear subspace fit (N4SID) with its order chosen by the free run on data that it has not fitted: a peer.

The state comes from an oblique projection of future outputs on past data along future inputs (Van Overschee, De Moor,
Subspace Identification, 1996, ch. 4); then all matrices are one regression. No physics, and no cause.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROWS = (12, 16, 24, 40)  # of past and of future
_ORDERS = (2, 4, 6, 8, 10, 14, 20)
_LARGEST = 0.9999  # of a pole
_MOST = 12_000  # samples that are fitted


def best_subspace(u: Array, y: Array, train: slice, test: slice) -> tuple[Array, int]:
    """Output over the test span, from the initial state that fits it best, and the order; (n,)."""
    cut = train.stop - (train.stop - train.start) // 10
    fitted = slice(max(train.start, cut - _MOST), cut)
    mean_u, mean_y = float(np.mean(u[fitted])), float(np.mean(y[fitted]))
    u, y = u - mean_u, y - mean_y
    check = slice(cut, train.stop)
    best: tuple[float, int, tuple[Array, Array, Array, float]] | None = None
    tried = ((rows, order) for rows in _ROWS for order in _ORDERS if order < rows)
    for rows, order in tried:
        model = _matrices(u[fitted], y[fitted], rows, order)
        missed = float(np.mean((_free_run(model, u[check], y[check]) - y[check]) ** 2))
        if best is None or missed < best[0]:
            best = (missed, order, model)
    assert best is not None
    return _free_run(best[2], u[test], y[test]) + mean_y, best[1]


def _matrices(u: Array, y: Array, rows: int, order: int) -> tuple[Array, Array, Array, float]:
    """A, b, c, d of x' = A x + b u, y = c x + d u."""
    columns = len(u) - 2 * rows + 1
    u_past, u_next = _hankel(u, 0, rows, columns), _hankel(u, rows, rows, columns)
    y_past, y_next = _hankel(y, 0, rows, columns), _hankel(y, rows, rows, columns)
    past = np.vstack([u_past, y_past])
    factor = np.linalg.lstsq(np.vstack([past, u_next]).T, y_next.T, rcond=1e-10)[0]
    projected = factor[: len(past)].T @ past
    left, size, _ = np.linalg.svd(projected @ projected.T)
    observed = left[:, :order] * size[:order] ** 0.25
    state = np.linalg.lstsq(observed, projected, rcond=None)[0]
    regressors = np.vstack([state[:, :-1], u_next[0, :-1]])
    wanted = np.vstack([state[:, 1:], y_next[0, :-1]])
    found = np.linalg.lstsq(regressors.T, wanted.T, rcond=None)[0].T
    return (
        _stable(found[:order, :order]),
        found[:order, order],
        found[order, :order],
        float(found[order, order]),
    )


def _stable(a: Array) -> Array:
    """The same with poles beyond the unit circle brought just inside."""
    poles, shapes = np.linalg.eig(a)
    poles = poles / np.maximum(np.abs(poles) / _LARGEST, 1.0)
    return np.asarray((shapes @ np.diag(poles) @ np.linalg.inv(shapes)).real)


def _hankel(values: Array, begin: int, rows: int, columns: int) -> Array:
    return np.vstack([values[begin + r : begin + r + columns] for r in range(rows)])


def _free_run(model: tuple[Array, Array, Array, float], u: Array, y: Array) -> Array:
    a, b, c, d = model
    driven, own = np.empty(len(u)), np.empty((len(u), len(b)))
    x, row = np.zeros(len(b)), c.copy()
    for k, force in enumerate(u):
        driven[k], own[k] = c @ x + d * force, row
        x, row = a @ x + b * force, row @ a
    begun = np.linalg.lstsq(own, y - driven, rcond=1e-8)[0]
    return np.asarray(driven + own @ begun)
