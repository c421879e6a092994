"""exp(-x^2), sine and cosine by sums and products alone, so that the compiler works out several at once.

A call of the mathematics library takes one number at a time, and holds up the loop that it is in. These are right to
1e-13.
"""

import numpy as np

from stillarm.simulation.arm.compiler import inlined

_MOST_EXPONENT = 40.0  # exp(-40) is 4e-18: nothing beside one
_SHARE = 1.0 / 64.0  # of the exponent, by which ten terms of the series suffice: it is squared six times
_PER_QUARTER = 2.0 / np.pi  # quarters of a turn, 1/rad
# pi/2 in three parts, of which the first has 33 bits, so that its multiples are exact (Cody and Waite, Software Manual
# for the Elementary Functions, 1980)
_HIGH, _MIDDLE, _LOW = 1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624871116645580e-21
_MOST_LEFT = 0.79  # rad, an eighth of a turn: beyond is the rounding of an angle that has run away


@inlined
def faded(ratio: float) -> float:
    """exp(-ratio^2)."""
    x = -_SHARE * min(ratio * ratio, _MOST_EXPONENT)
    one = 1.0 + x * (1.0 / 11.0)
    one = 1.0 + x * (1.0 / 10.0) * one
    one = 1.0 + x * (1.0 / 9.0) * one
    one = 1.0 + x * (1.0 / 8.0) * one
    one = 1.0 + x * (1.0 / 7.0) * one
    one = 1.0 + x * (1.0 / 6.0) * one
    one = 1.0 + x * (1.0 / 5.0) * one
    one = 1.0 + x * (1.0 / 4.0) * one
    one = 1.0 + x * (1.0 / 3.0) * one
    one = 1.0 + x * (1.0 / 2.0) * one
    one = 1.0 + x * one
    one *= one
    one *= one
    one *= one
    one *= one
    one *= one
    return one * one


@inlined
def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle of up to some 1e6 rad."""
    quarters = np.rint(angle * _PER_QUARTER)
    x = ((angle - quarters * _HIGH) - quarters * _MIDDLE) - quarters * _LOW
    x = min(max(x, -_MOST_LEFT), _MOST_LEFT)
    turned = quarters - 4.0 * np.floor(0.25 * quarters)  # 0, 1, 2 or 3
    y = x * x
    sine = x * (
        1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110 * (1 - y / 156 * (1 - y / 210))))))
    )
    cosine = 1 - y / 2 * (
        1
        - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132 * (1 - y / 182 * (1 - y / 240))))))
    )
    odd = (turned - 1.0) * (turned - 3.0) == 0.0
    first, second = (cosine, sine) if odd else (sine, cosine)
    return (-first if turned >= 2.0 else first), (-second if 0.5 < turned < 2.5 else second)


__all__ = ["faded", "sine_cosine"]
