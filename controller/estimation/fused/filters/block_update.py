"""An accelerometer block processed by all filters, and the step from its start to its end.

Implements Eqs. 5, 11, 12, 29 of docs/fused.md.
"""

from cmath import exp
from typing import NamedTuple

import numpy as np

from stillarm.controller.estimation.fused.accelerometer.blocks import Block
from stillarm.controller.estimation.fused.filters.bank import FilterBank
from stillarm.controller.estimation.fused.filters.laws import FILTERS, Array, ComplexArray
from stillarm.controller.estimation.fused.small_arrays import quadratic_form, summed


class BlockInnovation(NamedTuple):
    """An accelerometer block as each filter sees it: its value by each mode's phasor, and by its slow rate, m s; both
    (filters, m); residual, m, (filters,)."""

    gain: ComplexArray
    by_rate: ComplexArray
    residual: Array


def block_innovation(bank: FilterBank, block: Block) -> BlockInnovation:
    """The accelerometer's block that begins at edge_s: z = - sum Re(lambda^2 Z exp(i w t)) / w_1^2 + bias."""
    at = bank.at
    z, slow = bank.phasors(), bank.slow_rates()
    fast = slow + bank.iw
    lag = block.time_s - bank.edge_s
    gain = fast * fast * np.exp(slow * lag) * (np.array(block.turn) * (-1.0 / at.w_first**2))
    value = z * gain
    residual = block.value - block.forced - summed(value.real, 1) - bank.x[:, at.bias]
    return BlockInnovation(gain, value * (lag + 2.0 / fast), residual)


def update_by_block(
    bank: FilterBank, innovation: BlockInnovation, variance: float, shown: tuple[float, float] | None
) -> None:
    """Measurement update by a block; the bank must not have changed since its innovation; variance, m^2.

    shown: covariance of the block's value with what moves the first mode's phasor meanwhile, m^2.
    """
    at, gain, by_rate = bank.at, innovation.gain, innovation.by_rate
    slope = np.zeros(bank.x.shape)
    slope[:, at.cosine], slope[:, at.sine] = gain.real, gain.imag
    slope[:, at.frequency], slope[:, at.decay] = -by_rate.imag, -by_rate.real
    slope[:, at.bias] = 1.0
    ph = np.matvec(bank.p, slope)
    total = (np.vecdot(ph, slope) + variance)[:, None]
    if shown is not None:
        ph[:, :2] += shown
    weight = ph / total
    bank.x += weight * innovation.residual[:, None]
    bank.p -= weight[:, :, None] * ph[:, None, :]


def expected_block(bank: FilterBank, block: Block, one: int) -> tuple[float, float, float, float]:
    """The block's value without bias and joint; and by filter `one` the expected value, the value expected a quarter of
    a period later, and the variance of the expected value."""
    at = bank.at
    x: list[float] = bank.x[one].tolist()  # plain: of one filter these are too few for arrays
    m, lag, seen = at.modes, block.time_s - bank.edge_s, 0j
    row: list[float] = []
    for i, turn in enumerate(block.turn):
        slow = complex(-bank.sigma[i] - x[3 * m + i], x[2 * m + i])
        gain = (slow + 1j * bank.w[i]) ** 2 * turn * bank.per_acceleration
        seen += complex(x[2 * i], -x[2 * i + 1]) * gain * exp(slow * lag)
        row += (gain.real, gain.imag)
    variance = quadratic_form(row, bank.p[one, at.phasor, at.phasor].tolist())
    return block.value - block.forced - x[at.bias], seen.real, -seen.imag, variance


def move_on(bank: FilterBank, block: Block, noise: Array) -> None:
    """From the block's start to its end, adding `noise` (filters, n) to the covariances' diagonals."""
    at = bank.at
    dt = block.end_s - bank.edge_s
    turn = np.exp(bank.slow_rates() * dt)
    z = bank.phasors() * turn
    f, m = bank.move, at.modes  # the rows of the phasors; all else stays
    for i in range(m):
        c, s, kw, kd = 2 * i, 2 * i + 1, 2 * m + i, 3 * m + i
        by_rate = dt * z[:, i]
        f[:, c, c] = f[:, s, s] = turn.real[:, i]
        f[:, c, s] = turn.imag[:, i]
        f[:, s, c] = -turn.imag[:, i]
        f[:, s, kd] = by_rate.imag
        f[:, c, kw] = -by_rate.imag
        f[:, s, kw] = f[:, c, kd] = -by_rate.real
    z += np.array(block.step) * (0.5 + 0.5 * turn)
    bank.x[:, at.cosine], bank.x[:, at.sine] = z.real, -z.imag
    p, moved = bank.p, f @ bank.p
    p[:, at.phasor, :] = moved
    p[:, :, at.phasor] = moved.transpose(0, 2, 1)
    p[:, at.phasor, at.phasor] = moved @ f.transpose(0, 2, 1)
    diagonal = p.reshape(FILTERS, -1)[:, :: at.size + 1]
    diagonal += noise
    bank.edge_s = block.end_s
