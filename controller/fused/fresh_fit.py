"""The vibration as the last images alone have it: what a filter that was led astray is started from again.

Over a window of at most one and a half periods, by each filter's own dates, image zero, scale, frequencies and decay,
the images are linear in the phasors Z at the bank's instant t (docs/fused.md, section 9):

    y_k - (1 + e)(L theta_k + Re(G_k exp(j w t_k))) - c = (1 + e) Re(Z exp((slow + j w)(t_k - t) + j w t)) + f      (9.1)

with f a constant force, or none. What the fit takes as given is uncertain itself; the covariance of Z has that, too:
Z = fit(n) + J (n - n_0), so that cov(Z, n) = J P_n and cov(Z) = cov(fit) + J P_n J'.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controller.fused.bank import FILTERS, LAW_OF, FilterBank
from controller.fused.joint_input import JointInput
from controller.fused.layout import Layout

Array = NDArray[np.float64]

_HELD_IMAGES = 128
_JOINT_HELD_S = 0.95  # JointInput holds a second
_RIDGE = 1e-6  # of one image's information: a window too short for two phasors has no inverse


class Window(NamedTuple):
    """The newest k images: nominal instants by each law, s, (k, laws); values, m, and their variances, m^2, (k,)."""

    nominal_s: Array
    value_m: Array
    noise_m2: Array


class Fresh(NamedTuple):
    """What images alone say, by each filter. found: phasors at the bank's instant, a_1, b_1, ..., and, behind them, the
    force, where one is fitted, m, (filters, p); covariance: of them, with all else given, (filters, p, p); by_state:
    their derivative by the state, zero by themselves, (filters, p, n); misfit: mean squared normalised residual,
    (filters,), of `freedom` degrees of freedom."""

    found: Array
    covariance: Array
    by_state: Array
    misfit: Array
    freedom: int


class HeldImages:
    """The last images, for fits of their own."""

    def __init__(self, frame_s: float) -> None:
        """frame_s: nominal period of the frames."""
        self._frame_s = frame_s
        self._held: deque[tuple[Array, float, float]] = deque(maxlen=_HELD_IMAGES)

    def add(self, nominal_s: Array, value_m: float, noise_m2: float) -> None:
        """An image: its nominal instant by each law, s, (laws,), and what it shows, m, with its variance, m^2."""
        self._held.append((nominal_s.copy(), value_m, noise_m2))

    def forget(self) -> None:
        """The laws' instants have changed."""
        self._held.clear()

    def newest(self, span_s: float, law: int, now_s: float) -> Window | None:
        """Those of the last span_s by a law, as far as the joint's motion is still known; None for fewer than six."""
        held = self._held
        if not held:
            return None
        first_s = max(held[-1][0][law] - span_s, now_s - _JOINT_HELD_S)
        chosen = [one for one in held if one[0][law] >= first_s]
        if len(chosen) < 6:
            return None
        nominal, value, noise = zip(*chosen, strict=True)
        return Window(np.array(nominal), np.array(value), np.array(noise))


def fresh_fit(
    window: Window, bank: FilterBank, at: Layout, joint: JointInput, amplitude_m: float, *, force: bool
) -> Fresh:
    """Fit (9.1) by weighted least squares, for all filters at once; force: with a constant one."""
    times = window.nominal_s[:, LAW_OF].T + bank.x[:, at.shift, None]  # (filters, k)
    m, k = at.modes, times.shape[1]
    theta, rate, step = joint.seen_from(bank.edge_s, times.ravel())
    turn, fast = bank.turned_to(times), bank.fast_rates()[:, None, :]  # (filters, k or 1, modes)
    moved = step.reshape(FILTERS, k, m) * turn
    tip = theta.reshape(FILTERS, k) * at.lever + moved.real.sum(axis=2)
    scale = 1.0 + bank.x[:, at.scale, None]
    residual = window.value_m - scale * tip - bank.x[:, at.offset, None]
    columns = np.empty((FILTERS, k, 2 * m + int(force)))
    columns[:, :, 0 : 2 * m : 2], columns[:, :, 1 : 2 * m : 2] = turn.real, turn.imag
    columns[:, :, 2 * m :] = 1.0
    columns *= scale[:, :, None]
    own_date = 0.5 * (at.w_first * amplitude_m) ** 2 * bank.jitter
    weight = 1.0 / (window.noise_m2 + own_date[:, None])
    weighted = (columns * weight[:, :, None]).transpose(0, 2, 1)
    covariance = np.linalg.inv(
        weighted @ columns + _RIDGE / window.noise_m2.mean() * np.eye(columns.shape[2])
    )
    found = (covariance @ (weighted @ residual[:, :, None]))[:, :, 0]
    left = residual - (columns @ found[:, :, None])[:, :, 0]
    freedom = max(1, k - columns.shape[2])
    misfit = (left * left * weight).sum(axis=1) / freedom
    z = found[:, 0 : 2 * m : 2] - 1j * found[:, 1 : 2 * m : 2]
    own = z[:, None, :] * turn
    slope = np.zeros((FILTERS, k, at.size))
    lag = (times - bank.edge_s)[:, :, None]
    slope[:, :, at.frequency], slope[:, :, at.decay] = (
        -own.imag * lag * scale[:, :, None],
        -own.real * lag * scale[:, :, None],
    )
    slope[:, :, at.offset] = 1.0
    force_m = found[:, 2 * m :].sum(axis=1)[:, None]
    slope[:, :, at.scale] = tip + own.real.sum(axis=2) + force_m
    rates = rate.reshape(FILTERS, k) * at.lever + ((own + moved) * fast).real.sum(axis=2)
    slope[:, :, at.shift] = scale * rates
    return Fresh(found, covariance, -covariance @ (weighted @ slope), misfit, freedom)
