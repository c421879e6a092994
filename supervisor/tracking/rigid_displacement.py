"""One rigid displacement from many matched points: Tukey M-estimator by iteratively reweighted least squares.

    q_k = R(rotation) p_k + d + residual_k,       p_k, q_k about the image's centre
    weight_k = (1 - (|residual_k| / (c s))^2)^2 inside c s, 0 outside,      c = 4.6851
    s = 1.4826 MAD of the residuals' components about their median, no smaller than a floor in px

Each weighted least-squares step is solved in closed form (weighted Procrustes). Tukey's weights have local
minima, so
the start matters: the median motion with the rotation that was expected, where the points scatter little
about it; else the least median of squares over two-point hypotheses (Rousseeuw 1984), in a fixed order.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vectors = NDArray[np.float64]

TUKEY = 4.6851
MAD_TO_STD = 1.4826
SCALE_FLOOR_PX = 0.02
_GOOD_START_PX = 0.5
_ITERATIONS = 12
_HYPOTHESES = 60
_STILL_PX = 1e-4


@dataclass(frozen=True, slots=True)
class RigidFit:
    """dx, dy in px, rotation in rad; covariance of the three, (3, 3); weights (n,) in 0..1; scale s in px."""

    dx: float
    dy: float
    rotation: float
    covariance: Vectors
    weights: Vectors
    scale: float

    @property
    def inliers(self) -> int:
        """How many points keep more than a tenth of their weight."""
        return int(np.count_nonzero(self.weights > 0.1))


def fit_rigid(
    points: Vectors, moved: Vectors, expected_rotation: float = 0.0, scale_floor_px: float = SCALE_FLOOR_PX
) -> RigidFit | None:
    """Fit dx, dy and rotation; points and moved: shape (n, 2), px, about the image's centre.

    None with fewer than 3 points, or when those that agree do not determine a displacement.
    """
    if len(points) < 3:
        return None
    rotation, shift = _expected_start(points, moved, expected_rotation)
    weights = np.ones(len(points))
    scale = scale_floor_px
    reach = float(np.abs(points).max())
    for _ in range(_ITERATIONS):
        residual = _residual(points, moved, rotation, shift)
        scale = max(MAD_TO_STD * _median(np.abs(residual - _medians(residual)).ravel()), scale_floor_px)
        ratio = (residual[:, 0] ** 2 + residual[:, 1] ** 2) / (TUKEY * scale) ** 2
        weights = np.maximum(1.0 - ratio, 0.0) ** 2
        if np.count_nonzero(weights) < 3:
            return None
        before = rotation, shift
        rotation, shift = _weighted_least_squares(points, moved, weights)
        if abs(rotation - before[0]) * reach + float(np.abs(shift - before[1]).max()) < _STILL_PX:
            break
    covariance = _covariance(points, moved, rotation, shift, weights, scale_floor_px)
    if covariance is None:
        return None
    return RigidFit(float(shift[0]), float(shift[1]), float(rotation), covariance, weights, scale)


def _turned(points: Vectors, rotation: float) -> Vectors:
    c, s = np.cos(rotation), np.sin(rotation)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def _residual(points: Vectors, moved: Vectors, rotation: float, shift: Vectors) -> Vectors:
    return np.asarray(moved - _turned(points, rotation) - shift)


def _median(values: Vectors) -> float:
    middle = len(values) // 2
    return float(np.partition(values, middle)[middle])


def _medians(vectors: Vectors) -> Vectors:
    ordered = np.sort(vectors, axis=0)
    n = len(vectors)
    return np.asarray(0.5 * (ordered[(n - 1) // 2] + ordered[n // 2]))


def _expected_start(points: Vectors, moved: Vectors, rotation: float) -> tuple[float, Vectors]:
    residual = moved - _turned(points, rotation)
    shift = _medians(residual)
    if _median(np.abs(residual - shift).max(axis=1)) <= _GOOD_START_PX:
        return rotation, shift
    return _least_median_start(points, moved)


def _least_median_start(points: Vectors, moved: Vectors) -> tuple[float, Vectors]:
    n = len(points)
    k = np.arange(_HYPOTHESES)
    a = k % n
    b = (a + n // 2 + (k // n) * 7 + (n < 3)) % n
    b = np.where(b == a, (b + 1) % n, b)
    p, q = points[b] - points[a], moved[b] - moved[a]
    rotation = np.arctan2(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0], (p * q).sum(axis=1))
    c, s = np.cos(rotation)[:, None], np.sin(rotation)[:, None]
    middle_p, middle_q = 0.5 * (points[a] + points[b]), 0.5 * (moved[a] + moved[b])
    x, y = points[:, 0], points[:, 1]
    rest_x = moved[:, 0] - (c * (x - middle_p[:, :1]) - s * (y - middle_p[:, 1:])) - middle_q[:, :1]
    rest_y = moved[:, 1] - (s * (x - middle_p[:, :1]) + c * (y - middle_p[:, 1:])) - middle_q[:, 1:]
    best = int(np.argmin(np.median(rest_x**2 + rest_y**2, axis=1)))
    turn = float(rotation[best])
    return turn, middle_q[best] - _turned(middle_p[best : best + 1], turn)[0]


def _weighted_least_squares(points: Vectors, moved: Vectors, weights: Vectors) -> tuple[float, Vectors]:
    total = weights.sum()
    centre_p, centre_q = weights @ points / total, weights @ moved / total
    p, q = points - centre_p, moved - centre_q
    cross = float(weights @ (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]))
    along = float(weights @ (p[:, 0] * q[:, 0] + p[:, 1] * q[:, 1]))
    rotation = float(np.arctan2(cross, along))
    return rotation, centre_q - _turned(centre_p[None, :], rotation)[0]


def _covariance(
    points: Vectors, moved: Vectors, rotation: float, shift: Vectors, weights: Vectors, floor_px: float
) -> Vectors | None:
    """sigma^2 (sum w J^T J)^-1, with J = [[1, 0, -y], [0, 1, x]] at the turned point."""
    total = weights.sum()
    freedom = 2.0 * total - 3.0
    if freedom < 1.0:
        return None
    residual = _residual(points, moved, rotation, shift)
    x, y = _turned(points, rotation).T
    wx, wy = weights @ x, weights @ y
    normal = np.array([[total, 0.0, -wy], [0.0, total, wx], [-wy, wx, weights @ (x * x + y * y)]])
    if np.linalg.cond(normal) > 1e12:
        return None
    variance = float(weights @ (residual * residual).sum(axis=1)) / freedom
    return np.asarray(max(variance, floor_px**2) * np.linalg.inv(normal))
