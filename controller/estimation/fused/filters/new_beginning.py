"""Filters that begin anew: from another filter, from a fit to images, or from what was known before.

Implements Eqs. 39, 46 of docs/fused.md.
"""

import numpy as np

from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import DISTURBED, LAWS, Array, Law


def begin_near(bank: FilterBank, x: Array) -> None:
    """As at the start, but for the vibration and the image's zero, which are those of the state x (n,)."""
    at = bank.at
    phasor, offset = x[at.phasor], float(x[at.offset])
    bank.begin()
    bank.x[:, at.phasor], bank.x[:, at.offset] = phasor, offset
    doubt = bank.assumed.consistency.doubt_of_lost**2 * float(phasor @ phasor)
    i = bank.diagonal[at.phasor]
    bank.p[:, i, i] = np.minimum(
        bank.p[:, i, i], doubt + bank.assumed.consistency.least_of_lost * bank.p[:, i, i]
    )


def start_vibration(bank: FilterBank, states: list[int], mean: Array, covariance: Array, parts: int) -> None:
    """Take the vibration from a fit to images alone (fresh_fit.Fresh), and the force, where one was fitted, or else
    none. What the fit says of other states moves those that it did not ask for, as far as they are correlated."""
    at = bank.at
    known = states[parts:]
    rest = [i for i in range(2 * at.modes, at.size) if i != at.force and i not in known]
    prior = bank.p[:, known][:, :, known]
    by_known = np.linalg.solve(prior, bank.p[:, known][:, :, rest]).transpose(0, 2, 1)  # of the rest
    own = covariance[:, parts:, parts:]
    bank.x[:, rest] += (by_known @ (mean[:, parts:] - bank.x[:, known])[:, :, None])[:, :, 0]
    p_rest = bank.p[:, rest][:, :, rest] - by_known @ (prior - own) @ by_known.transpose(0, 2, 1)
    cross = by_known @ covariance[:, parts:]  # of the rest with all states of the fit
    bank.x[:, at.phasor], bank.x[:, at.force] = 0.0, 0.0
    bank.p[:] = 0.0
    bank.x[:, states] = mean
    at_fit, at_rest = np.array(states), np.array(rest)
    bank.p[:, at_fit[:, None], at_fit] = covariance
    bank.p[:, at_rest[:, None], at_rest] = p_rest
    bank.p[:, at_rest[:, None], at_fit] = cross
    bank.p[:, at_fit[:, None], at_rest] = cross.transpose(0, 2, 1)
    bank.x[DISTURBED, at.force] = 0.0  # the disturbed filters have none
    bank.p[DISTURBED, at.force, :] = bank.p[DISTURBED, :, at.force] = 0.0


def restore(bank: FilterBank, x: Array, p: Array, grown: Array) -> None:
    """All but the vibration and the force as they were: x (filters, n), p (filters, n, n), and by how much their
    variances have grown since, (filters, n)."""
    at = bank.at
    rest = np.array([i for i in range(2 * at.modes, at.size) if i != at.force])
    bank.x[:, rest] = x[:, rest]
    bank.p[:] = 0.0
    bank.p[:, rest[:, None], rest] = p[:, rest[:, None], rest]
    bank.p[:, rest, rest] += grown[:, rest]
    bank.all_moved()


def forget_phase(bank: FilterBank, spread_m: float, x: Array, p: Array, grown: Array) -> None:
    """An impact that the images alone have shown: the vibration is unknown, all else what it was before it to the laws
    that let the delay walk.

    Images taken in before the impact was noticed have moved it, and without an accelerometer nothing would bring it
    back. Delay and frequency stay correlated: a frequency that is off lets the delay walk off through all impacts.
    x, p: before the impact; grown: by how much the variances have grown since, (filters, n).
    """
    at = bank.at
    walks, rest = slice(int(Law.DRIFT), None, LAWS), slice(2 * at.modes, at.size)
    bank.x[walks, rest] = x[walks, rest]
    bank.p[walks, rest, rest] = p[walks, rest, rest]
    bank.p[walks, bank.diagonal[rest], bank.diagonal[rest]] += grown[walks, rest]
    for i in range(2 * at.modes):
        bank.p[:, i, :] = bank.p[:, :, i] = 0.0
    bank.p[:, bank.diagonal[at.phasor], bank.diagonal[at.phasor]] = spread_m**2


def start_anew(
    bank: FilterBank, target: int, source: int, shift_s: float, variances: tuple[float, float, float]
) -> None:
    """Give filter `target` what `source` knows of all but the dating; variances: of shift, skew and late."""
    at = bank.at
    bank.x[target], bank.p[target] = bank.x[source], bank.p[source]
    for i, variance in zip((at.shift, at.skew, at.late), variances, strict=True):
        bank.p[target, i, :] = bank.p[target, :, i] = 0.0
        bank.p[target, i, i] = variance
        bank.x[target, i] = 0.0
    bank.x[target, at.shift] = shift_s
    bank.moved[target] += 1


def copy_filter(bank: FilterBank, target: int, source: int) -> None:
    """Give filter `target` all that `source` of the same law knows."""
    bank.x[target], bank.p[target] = bank.x[source], bank.p[source]
    bank.moved[target] += 1
