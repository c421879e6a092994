"""A fit of the vibration to the last images alone, from which a filter that was led astray starts again.

Implements Eqs. 63, 64 of docs/fused.md.

Over a window of about a period, by each filter's own dates, the images are

    y_k = (1 + e)(L theta_k + Re(G_k exp(j w t_k)) + Re(Z exp((slow + j w)(t_k - t) + j w t)) + f) + c + noise    (63)

with Z the phasors at the bank's instant t, of which nothing is supposed to be known, and f a constant force, or none.
The filter's mean and covariance give its other unknowns: c, e, the dates' shift, frequencies, decay. If they are from
before these images, they are the prior of least squares, linearised once about the vibration that fits best (Gauss
and Newton). What images do not tell then stays as it was, such as the date of a vibration whose phase is unknown.
Where it has processed these images already, it stays as it is, and its doubt is in the fit's (consider parameters;
Schmidt 1966).
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.image_update import turned_to
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAW_OF

Array = NDArray[np.float64]


class Window(NamedTuple):
    """The newest k images: nominal instants by each law, s, (k, laws); values, m, and their variances, m^2, (k,).

    cost: what they have cost the filters, sum of nu^2 / S + log(S / R), innovation nu with variance S, of which R is
    the image's own; a fit that explains them costs k.
    """

    nominal_s: Array
    value_m: Array
    noise_m2: Array
    cost: float


class Fresh(NamedTuple):
    """What images alone say, by each filter. states: indices, (q,): phasors, the force, where one is fitted, and what
    was supposed to be known; mean: of them, (filters, q); covariance: (filters, q, q). parts: how many are phasors
    and force.

    misfit: mean squared normalised residual, that of what was supposed to be known included, (filters,), of `freedom`
    degrees of freedom. gain: by how much less the images cost than they have cost the filters, (filters,), what the fit
    had free being paid for (Akaike, IEEE Trans. Automatic Control 19, 1974).
    """

    states: list[int]
    mean: Array
    covariance: Array
    parts: int
    misfit: Array
    freedom: int
    gain: Array


class HeldImages:
    """The last images, for fits of their own."""

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """None yet."""
        self._assumed = assumed.fresh_start
        self._held: deque[tuple[Array, float, float, float]] = deque(maxlen=self._assumed.held_images)

    def add(self, nominal_s: Array, value_m: float, noise_m2: float, cost: float) -> None:
        """An image: its nominal instant by each law, s, (laws,), what it shows, m, with its variance, m^2, and what
        it has cost the filters (Window)."""
        self._held.append((nominal_s.copy(), value_m, noise_m2, cost))

    def forget(self) -> None:
        """The laws' instants have changed."""
        self._held.clear()

    def newest(self, span_s: float, law: int, now_s: float) -> Window | None:
        """Those of the last span_s by a law, or the last eight, as far as the joint's motion is still known; None for
        fewer than those."""
        known = [one for one in self._held if one[0][law] >= now_s - self._assumed.joint_held_s]
        if len(known) < self._assumed.fewest_images:
            return None
        first_s = min(known[-1][0][law] - span_s, known[-self._assumed.fewest_images][0][law])
        chosen = [one for one in known if one[0][law] >= first_s]
        nominal, value, noise, cost = zip(*chosen, strict=True)
        return Window(np.array(nominal), np.array(value), np.array(noise), sum(cost))


def fresh_fit(
    window: Window,
    bank: FilterBank,
    at: Layout,
    joint: JointInput,
    amplitude_m: float,
    *,
    force: bool,
    learn: bool,
) -> Fresh:
    """Fit Eq. 63 for all filters at once; force: with a constant one; learn: whether the filters have yet to take these
    images in."""
    times = window.nominal_s[:, LAW_OF].T + bank.x[:, at.shift, None]  # (filters, k)
    m, k, ridge = at.modes, times.shape[1], bank.assumed.fresh_start.ridge
    theta, rate, step = joint.seen_from(bank.edge_s, times.ravel())
    turn, fast = turned_to(bank, times), bank.fast_rates()[:, None, :]  # (filters, k or 1, modes)
    moved = step.reshape(FILTERS, k, m) * turn
    tip = theta.reshape(FILTERS, k) * at.lever + moved.real.sum(axis=2)
    scale = 1.0 + bank.x[:, at.scale, None]
    residual = window.value_m - scale * tip - bank.x[:, at.offset, None]
    parts, known = 2 * m + int(force), _known(at)
    slope = np.empty((FILTERS, k, parts + len(known)))
    slope[:, :, 0 : 2 * m : 2], slope[:, :, 1 : 2 * m : 2] = turn.real, turn.imag
    slope[:, :, 2 * m : parts] = 1.0
    slope[:, :, :parts] *= scale[:, :, None]
    own_date = 0.5 * (at.w_first * amplitude_m) ** 2 * bank.jitter
    weight = 1.0 / (window.noise_m2 + own_date[:, None])
    found, _ = _solve(slope[:, :, :parts], weight, residual, np.zeros((FILTERS, parts, parts)), ridge)
    own = (found[:, 0 : 2 * m : 2] - 1j * found[:, 1 : 2 * m : 2])[:, None, :] * turn
    lag = (times - bank.edge_s)[:, :, None] * scale[:, :, None]
    rates = rate.reshape(FILTERS, k) * at.lever + ((own + moved) * fast).real.sum(axis=2)
    slope[:, :, parts] = 1.0
    slope[:, :, parts + 1] = tip + own.real.sum(axis=2) + found[:, 2 * m :].sum(axis=1)[:, None]
    slope[:, :, parts + 2] = scale * rates
    slope[:, :, parts + 3 : parts + 3 + m], slope[:, :, parts + 3 + m :] = -own.imag * lag, -own.real * lag
    spread = bank.p[:, known][:, :, known]
    if learn:
        prior = np.linalg.inv(spread)
        precision = np.zeros((FILTERS, slope.shape[2], slope.shape[2]))
        precision[:, parts:, parts:] = prior
        found, covariance = _solve(slope, weight, residual, precision, ridge)
        moves = found[:, parts:]
        paid = np.einsum("fi,fij,fj->f", moves, prior, moves)
    else:
        found, covariance = _considering(slope, weight, found, spread)
        paid = np.zeros(FILTERS)
    left = residual - (slope @ found[:, :, None])[:, :, 0]
    cost = (left * left * weight).sum(axis=1) + paid
    freedom = max(1, k - parts)
    mean = found.copy()
    mean[:, parts:] += bank.x[:, known]
    states = [*range(2 * m), at.force][:parts] + known
    return Fresh(states, mean, covariance, parts, cost / freedom, freedom, window.cost - cost - 2.0 * parts)


def _considering(slope: Array, weight: Array, found: Array, spread: Array) -> tuple[Array, Array]:
    """What was supposed to be known stays as it is, with its covariance `spread`: mean and covariance of all."""
    parts, size = found.shape[1], slope.shape[2]
    weighted = (slope[:, :, :parts] * weight[:, :, None]).transpose(0, 2, 1)
    own = np.linalg.inv(weighted @ slope[:, :, :parts])
    by_known = -own @ (weighted @ slope[:, :, parts:])
    mean = np.concatenate((found, np.zeros((FILTERS, size - parts))), axis=1)
    covariance = np.empty((FILTERS, size, size))
    cross = by_known @ spread
    covariance[:, :parts, :parts] = own + cross @ by_known.transpose(0, 2, 1)
    covariance[:, :parts, parts:], covariance[:, parts:, :parts] = cross, cross.transpose(0, 2, 1)
    covariance[:, parts:, parts:] = spread
    return mean, covariance


def _known(at: Layout) -> list[int]:
    """States that an image's value depends on, but for phasors and force."""
    m = at.modes
    return [at.offset, at.scale, at.shift, *range(2 * m, 4 * m)]


def _solve(
    slope: Array, weight: Array, residual: Array, precision: Array, ridge_share: float
) -> tuple[Array, Array]:
    """Weighted least squares with a prior of that precision about zero: mean (filters, q), covariance."""
    weighted = (slope * weight[:, :, None]).transpose(0, 2, 1)
    ridge = ridge_share * weight.mean(axis=1)[:, None, None] * np.eye(slope.shape[2])
    covariance = np.linalg.inv(weighted @ slope + precision + ridge)
    return (covariance @ (weighted @ residual[:, :, None]))[:, :, 0], covariance
