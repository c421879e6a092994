"""Sum, maximum and quadratic form of a few numbers: numpy's own, and plain floats, where these cost less.

Implements Eq. 42 of docs/fused.md.
"""

from collections.abc import Sequence

import numpy as np

summed = np.add.reduce  # as ndarray.sum and .max, at half the cost
largest = np.maximum.reduce


def quadratic_form(row: Sequence[float], matrix: Sequence[Sequence[float]]) -> float:
    """r' P r for r of shape (n,) and P of shape (n, n): the variance of r' x where P is the covariance of x."""
    return sum(
        [
            a * b * entry
            for a, line in zip(row, matrix, strict=True)
            for b, entry in zip(row, line, strict=True)
        ]
    )
