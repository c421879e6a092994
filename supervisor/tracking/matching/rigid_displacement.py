"""One rigid displacement from many matched points: Tukey M-estimator by iteratively reweighted least squares.

    q_k = R(rotation) p_k + d + residual_k,       p_k, q_k about the image's centre
    weight_k = (1 - (|residual_k| / (c s))^2)^2 inside c s, 0 outside,      c = 4.6851
    s = 1.4826 MAD of the residuals' components about their median, no smaller than a floor in px

Each weighted least-squares step has a closed form (weighted Procrustes). Tukey's weights cause local minima, so the
start matters. It is the median motion with the expected rotation if the points scatter little about it, and otherwise
the least median of squares over two-point hypotheses (Rousseeuw 1984), in a fixed order.
"""

from cmath import phase, rect
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vectors = NDArray[np.float64]
ComplexVectors = NDArray[np.complex128]

TUKEY = 4.6851  # c: 95 % efficiency for Gaussian residuals
MAD_TO_STD = 1.4826  # 1 / Phi^-1(3/4), for Gaussian residuals
SCALE_FLOOR_PX = 0.02
_GOOD_START_PX = 0.5
_ITERATIONS = 12
_HYPOTHESES = 60
_STILL_PX = 1e-4
# rms distance from the centre of gravity: coincident points do not determine a rotation
_SMALLEST_LEVER_PX = 1e-3


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
        """Number of points that keep more than a tenth of their weight."""
        return int(np.count_nonzero(self.weights > 0.1))


def fit_rigid(points: Vectors, moved: Vectors, expected_rotation: float = 0.0) -> RigidFit | None:
    """Fit dx, dy and rotation; points and moved: shape (n, 2), px, about the image's centre.

    Returns None for fewer than 3 points, or if the points that agree do not determine a displacement.
    """
    if len(points) < 3:
        return None
    pairs = _Pairs(points, moved)
    motion = _expected_start(pairs, expected_rotation) or _least_median_start(points, moved)
    weights = np.ones(len(points))
    scale = SCALE_FLOOR_PX
    for _ in range(_ITERATIONS):
        residual = pairs.residual(motion)
        x, y = residual.real, residual.imag
        spread = np.abs(np.concatenate((x - _median(x), y - _median(y))))
        scale = max(MAD_TO_STD * _upper_median(spread), SCALE_FLOOR_PX)
        rest = np.maximum(1.0 - (x * x + y * y) / (TUKEY * scale) ** 2, 0.0)
        weights = rest * rest
        if np.count_nonzero(weights) < 3:
            return None
        before = motion
        motion = pairs.least_squares(weights)
        still = abs(motion.rotation - before.rotation) * pairs.reach + abs(motion.shift - before.shift)
        if still < _STILL_PX:
            break
    covariance = pairs.covariance(motion, weights, SCALE_FLOOR_PX)
    if covariance is None:
        return None
    return RigidFit(motion.shift.real, motion.shift.imag, motion.rotation, covariance, weights, float(scale))


class _Motion(NamedTuple):
    """rotation in rad; shift: x + i y, px."""

    rotation: float
    shift: complex


class _Pairs:
    """Matched points as complex numbers x + i y, so that a rotation is one product, which saves numpy calls."""

    def __init__(self, points: Vectors, moved: Vectors) -> None:
        self.p = points[:, 0] + 1j * points[:, 1]
        self.q = moved[:, 0] + 1j * moved[:, 1]
        self.rows = np.stack((self.p, self.q, self.p.conj() * self.q))
        self.reach = float(np.abs(points).max())

    def residual(self, motion: _Motion) -> ComplexVectors:
        """moved - R points - d."""
        return np.asarray(self.q - rect(1.0, motion.rotation) * self.p - motion.shift)

    def least_squares(self, weights: Vectors) -> _Motion:
        """The weighted Procrustes solution, in closed form."""
        total = float(weights.sum())
        p, q, product = (self.rows @ weights).tolist()
        rotation = phase(product - p.conjugate() * q / total)
        return _Motion(rotation, (q - rect(1.0, rotation) * p) / total)

    def covariance(self, motion: _Motion, weights: Vectors, floor_px: float) -> Vectors | None:
        """sigma^2 (sum w J^T J)^-1, with J = [[1, 0, -y], [0, 1, x]] at the turned point. The inverse uses the
        centre of gravity, about which displacement and rotation are decoupled.
        """
        total = float(weights.sum())
        freedom = 2.0 * total - 3.0
        if freedom < 1.0:
            return None
        residual = self.residual(motion)
        turned = self.q - residual - motion.shift
        centre = complex(weights @ turned) / total
        inertia = float(weights @ _squared(turned - centre))
        if inertia < _SMALLEST_LEVER_PX**2 * total:
            return None
        variance = max(float(weights @ _squared(residual)) / freedom, floor_px**2)
        one, turn, x, y = variance / total, variance / inertia, centre.real, centre.imag
        return np.array(
            [
                [one + y * y * turn, -x * y * turn, y * turn],
                [-x * y * turn, one + x * x * turn, -x * turn],
                [y * turn, -x * turn, turn],
            ]
        )


def _squared(values: ComplexVectors) -> Vectors:
    return np.asarray(values.real**2 + values.imag**2)


def _upper_median(values: Vectors) -> float:
    middle = len(values) // 2
    return float(np.partition(values, middle)[middle])


def _median(values: Vectors) -> float:
    n = len(values)
    ordered = np.partition(values, ((n - 1) // 2, n // 2))
    return 0.5 * float(ordered[(n - 1) // 2] + ordered[n // 2])


def _expected_start(pairs: _Pairs, rotation: float) -> _Motion | None:
    residual = pairs.residual(_Motion(rotation, 0j))
    x, y = residual.real, residual.imag
    shift_x, shift_y = _median(x), _median(y)
    scatter = _upper_median(np.maximum(np.abs(x - shift_x), np.abs(y - shift_y)))
    return _Motion(rotation, complex(shift_x, shift_y)) if scatter <= _GOOD_START_PX else None


def _least_median_start(points: Vectors, moved: Vectors) -> _Motion:
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
    p, q = complex(*middle_p[best].tolist()), complex(*middle_q[best].tolist())
    return _Motion(turn, q - rect(1.0, turn) * p)
