"""r' P r in plain floats: of so few numbers arrays cost more."""

from collections.abc import Sequence


def quadratic_form(row: Sequence[float], matrix: Sequence[Sequence[float]]) -> float:
    """r' P r for r of shape (n,) and P of shape (n, n): the variance of r' x where P is the covariance of x."""
    return sum(
        [
            a * b * entry
            for a, line in zip(row, matrix, strict=True)
            for b, entry in zip(row, line, strict=True)
        ]
    )
