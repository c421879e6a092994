"""Updates of the frames' dates without an image: by arrivals, n_i, and corrections.

Implements Eqs. 21, 22, 23, 62 of docs/fused.md.
"""

import numpy as np

from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import CLOCKED, FILTERS, Array


def advance_dating(
    bank: FilterBank, elapsed_s: Array, shift_return: Array, shift_noise: Array, skew_noise: float
) -> None:
    """Frames go on by `elapsed_s` of each filter's clock (filters,): its skew moves its shift.

    shift_noise, skew_noise: growth of the variances, s^2/s and 1/s. shift_return: rate at which a wandering delay comes
    back to its mean, 1/s: without it, the variance of a delay that can no longer be seen would grow without bound.
    """
    x, p, t, k, late = bank.x, bank.p, bank.at.shift, bank.at.skew, bank.at.late
    spent_s = np.abs(elapsed_s)
    back = -np.expm1(-shift_return * spent_s)
    x[:, t] += elapsed_s * x[:, k] - back * (x[:, t] + x[:, late])
    line = p[:, t, :] + elapsed_s[:, None] * p[:, k, :] - back[:, None] * (p[:, t, :] + p[:, late, :])
    own = line[:, t] + elapsed_s * line[:, k] - back * (line[:, t] + line[:, late])
    p[:, t, :] = p[:, :, t] = line
    p[:, t, t] = own + shift_noise * spent_s
    p[:, k, k] += skew_noise * spent_s


def update_by_arrival(bank: FilterBank, difference_s: Array, noise: Array, walk: Array) -> None:
    """Arrival minus nominal instant minus the model's delay (filters,) = shift + late + noise, variance in s^2.

    walk: growth of the variance of late since the last frame, s^2.
    """
    t, late = bank.at.shift, bank.at.late
    bank.p[:, late, late] += walk
    ph = bank.p[:, :, t] + bank.p[:, :, late]
    gain = ph / (ph[:, t] + ph[:, late] + noise)[:, None]
    bank.x += gain * (difference_s - bank.x[:, t] - bank.x[:, late])[:, None]
    bank.p -= gain[:, :, None] * ph[:, None, :]


def update_by_started(bank: FilterBank, difference_s: Array, noise: Array, walk: Array) -> None:
    """n_i plus a frame minus nominal instant (filters,) = shift - ahead + noise, variance in s^2.

    walk: growth of the variance of ahead since the last frame, s^2.
    """
    t, ahead = bank.at.shift, bank.at.ahead
    bank.p[:, ahead, ahead] += walk
    ph = bank.p[:, :, t] - bank.p[:, :, ahead]
    gain = ph / (ph[:, t] - ph[:, ahead] + noise)[:, None]
    bank.x += gain * (difference_s - bank.x[:, t] + bank.x[:, ahead])[:, None]
    bank.p -= gain[:, :, None] * ph[:, None, :]


def redate(bank: FilterBank, later_s: float) -> None:
    """Date all frames later by later_s, with an uncertainty of a share of that, and the vibration that they show with
    them. Images cannot tell it, because phase and date go together."""
    at = bank.at
    z = bank.phasors()
    turned = z * np.exp(-1j * bank.w_modes * later_s)
    bank.x[:, at.cosine], bank.x[:, at.sine] = turned.real, -turned.imag
    bank.x[:, at.shift] += later_s
    bank.x[:, at.late] -= later_s
    doubt_dates(bank, np.full(FILTERS, (bank.assumed.dates.redated * later_s) ** 2))


def doubt_dates(bank: FilterBank, variance: Array) -> None:
    """Add to the variance of all dates, s^2, (filters,), with the vibration that the frames show."""
    at = bank.at
    by_date = -1j * bank.w_modes * bank.phasors()
    direction = np.zeros(bank.x.shape)
    direction[:, at.cosine], direction[:, at.sine] = by_date.real, -by_date.imag
    direction[:, at.shift], direction[:, at.late] = 1.0, -1.0
    bank.p += variance[:, None, None] * direction[:, :, None] * direction[:, None, :]


def doubt_lateness(bank: FilterBank, clocked: float, others: float) -> None:
    """Add to the variances, s^2, of how late images come: of the mean delay by a clock's laws, and by the others, which
    know no instant apart from it, of their instants."""
    t, late = bank.at.shift, bank.at.late
    bank.p[CLOCKED, late, late] += clocked
    bank.p[~CLOCKED, t, t] += others


def begin_late(bank: FilterBank, one: int, late_s: float) -> None:
    """Filter `one`: the mean delay is unknown; arrivals are late_s later than their nominal instants say."""
    t, late = bank.at.shift, bank.at.late
    bank.p[one, late, :] = bank.p[one, :, late] = 0.0
    bank.p[one, late, late] = bank.assumed.dates.late_s**2
    bank.x[one, late] = late_s - bank.x[one, t]


def place(bank: FilterBank, one: int, shift_s: float) -> None:
    """Filter `one`: set the clock's shift to shift_s, the arrivals' value; nothing else has shown it yet."""
    t, late = bank.at.shift, bank.at.late
    for i in (t, late):
        bank.p[one, i, :] = bank.p[one, :, i] = 0.0
        bank.p[one, i, i] = bank.first[one, i]
    bank.x[one, t], bank.x[one, late] = shift_s, 0.0


def forget_started(bank: FilterBank, variance: float) -> None:
    """Forget n_i's lead, which has jumped; variance in s^2."""
    ahead = bank.at.ahead
    bank.p[:, ahead, :] = bank.p[:, :, ahead] = 0.0
    bank.p[:, ahead, ahead] = variance
