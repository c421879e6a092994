"""Sudden changes, applied to all filters: impacts, forces, another payload or scene, another image zero.

Implements Eqs. 49, 53, 55, 58 of docs/fused.md.
"""

from cmath import exp

import numpy as np

from stillarm.controller.estimation.fused.accelerometer.blocks import Jump, along_rate
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import ALL, QUIET


def inflate(bank: FilterBank, jump: Jump, filters: slice = ALL) -> None:
    """An impact has moved the phasors, or a force has changed, by an unknown amount. filters: that are told of the
    force."""
    for i, (along_m, across_m) in enumerate(zip(jump.along_m, jump.across_m, strict=True)):
        along = along_rate(bank.w[i], jump.time_s)
        cosine, sine = along.real, -along.imag
        c, d, rest = 2 * i, 2 * i + 1, across_m**2
        power = along_m**2 - rest
        bank.p[:, c, c] += power * cosine * cosine + rest
        bank.p[:, d, d] += power * sine * sine + rest
        bank.p[:, c, d] += power * cosine * sine
        bank.p[:, d, c] += power * cosine * sine
    if jump.force_step_m:
        turn = jump.force_step_m * exp(-1j * bank.w[0] * jump.time_s)
        bank.x[:, bank.forced] += (-turn.real, turn.imag, jump.force_step_m)
    if jump.force_m:
        _change_force(bank, jump, filters)


def _change_force(bank: FilterBank, jump: Jump, filters: slice) -> None:
    """The force changed at the jump's instant, by an unknown amount: neither deflection nor rate jumps with it."""
    turn = exp(1j * bank.w[0] * jump.time_s)
    moved = jump.force_m * np.array((-turn.real, -turn.imag, 1.0))
    i = np.array(bank.forced)
    bank.p[filters, i[:, None], i] += moved[:, None] * moved


def let_scale_walk(bank: FilterBank, variance: float, held_m: float) -> None:
    """The scale may have changed, variance: of what vibrates about held_m, where the joint holds the tip, while
    images show that place where they did."""
    c, e = bank.at.offset, bank.at.scale
    bank.p[:, e, e] += variance
    bank.p[:, c, c] += variance * held_m * held_m
    bank.p[:, c, e] -= variance * held_m
    bank.p[:, e, c] -= variance * held_m


def give_force(bank: FilterBank, offset_m: float) -> None:
    """The image's zero has followed a force by about offset_m: that much is the force's, give or take as much.

    Their sum, which images show, stays.
    """
    c, f = bank.at.offset, bank.at.force
    bank.x[:, c] -= offset_m
    bank.x[QUIET, f] += offset_m
    doubt = offset_m * offset_m
    bank.p[QUIET, c, c] += doubt
    bank.p[QUIET, f, f] += doubt
    bank.p[QUIET, c, f] -= doubt
    bank.p[QUIET, f, c] -= doubt


def end_force(bank: FilterBank) -> None:
    """End the force: f = 0 as a measurement, because f is correlated with all other states."""
    i = bank.at.force
    ph = bank.p[:, :, i].copy()
    variance = ph[:, i]
    known = variance > 0.0
    gain = np.where(known[:, None], ph / np.where(known, variance, 1.0)[:, None], 0.0)
    bank.x -= gain * bank.x[:, i, None]
    bank.p -= gain[:, :, None] * ph[:, None, :]
    bank.x[:, i] = 0.0
    bank.p[:, i, :] = bank.p[:, :, i] = 0.0


def add_step(bank: FilterBank, increment: list[complex]) -> None:
    """An impact that is known has moved the phasors by `increment`, (m,)."""
    z = np.array(increment)
    bank.x[:, bank.at.cosine] += z.real
    bank.x[:, bank.at.sine] -= z.imag


def loosen(bank: FilterBank, filters: slice = ALL) -> None:
    """Frequencies, decay and image scale may have changed, as with a payload or another scene."""
    at, loose = bank.at, bank.assumed.outlier
    for states, spread in (
        (range(2 * at.modes, 3 * at.modes), loose.loose_frequency * at.w),
        (range(3 * at.modes, 4 * at.modes), loose.loose_decay * at.w),
        ((at.scale,), np.array([loose.loose_scale])),
    ):
        for i, one in zip(states, spread.tolist(), strict=True):
            bank.p[filters, i, i] = np.maximum(bank.p[filters, i, i], one * one)
    bank.all_moved()


def loosen_bias(bank: FilterBank, variance: float) -> None:
    """The accelerometer's bias has changed by about the root of variance, m^2."""
    bank.p[:, bank.at.bias, bank.at.bias] += variance


def forget_zero(bank: FilterBank) -> None:
    """Images count from another zero."""
    c = bank.at.offset
    bank.x[:, c] = 0.0
    bank.p[:, c, :] = bank.p[:, :, c] = 0.0
    bank.p[:, c, c] = bank.first[:, c]
