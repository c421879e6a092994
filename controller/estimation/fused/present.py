"""The phasors as they are now: from the filters' mixture at the bank's instant through the blocks since then.

Implements Eqs. 5, 12, 40, 41, 42, 43 of docs/fused.md.

Present has plain floats: it runs once a block and once a frame for each block since the frame's exposure.
"""

from cmath import exp
from math import sqrt
from typing import NamedTuple

import numpy as np

from stillarm.controller.estimation.fused.accelerometer.blocks import Block, Jump, along_rate
from stillarm.controller.estimation.fused.filters.laws import FILTERS
from stillarm.controller.estimation.fused.fusion.state import FusionState
from stillarm.controller.estimation.fused.learning.stated_scale import with_stated_scale
from stillarm.controller.estimation.fused.small_arrays import quadratic_form


class Merged(NamedTuple):
    """The filters' common state: phasors, slow rates, 1/s, accelerometer bias, m, static deflection by a force, m, and
    the covariance of the phasors, with the force behind them where there may be one."""

    phasors: list[complex]
    slow: list[complex]
    bias: float
    bias_variance: float
    force: float
    covariance: list[list[float]]


class Mixture:
    """Weighs the filters by their probabilities, and by the model's word on the image's scale."""

    def __init__(self, state: FusionState) -> None:
        """state: has filters and probabilities."""
        self._state = state
        self._carried = np.eye(state.at.size)[[*range(2 * state.at.modes), state.at.force]]

    def phasor_noise(self) -> float:
        """Growth of the variance of each phasor component, m^2/s."""
        return float(self._state.evidence.weights @ self._state.phasor_noise())

    def merged(self, now_s: float) -> Merged:
        """Phasors at the bank's instant, with their covariance at now_s if no newer image comes."""
        state = self._state
        bank, at, w = state.bank, state.at, state.evidence.weights
        best = state.evidence.best
        if w[best] > state.assumed.update.clear:
            x, p = bank.x[best], bank.p[best]
        else:
            x = w @ bank.x
            d = bank.x - x
            p = (w @ bank.p.reshape(FILTERS, -1)).reshape(at.size, at.size) + (d * w[:, None]).T @ d
        if state.as_calibrated:
            x, p = with_stated_scale(
                x, p, at.scale, state.first_scale, state.stated_scale, state.assumed.scale
            )
        m = at.modes
        phasors: list[complex] = (x[at.cosine] - 1j * x[at.sine]).tolist()
        lag = now_s - bank.edge_s
        f = self._carried  # the rows of the phasors
        for i, one in enumerate(phasors):
            by_rate = lag * one
            c, s, kw, kd = 2 * i, 2 * i + 1, 2 * m + i, 3 * m + i
            f[c, kw], f[s, kd] = -by_rate.imag, by_rate.imag
            f[s, kw] = f[c, kd] = -by_rate.real
        rows = 2 * m + int(state.held_force.active)
        f = f[:rows]
        covariance: list[list[float]] = (f @ p @ f.T).tolist()
        noise = self.phasor_noise() * lag
        for i in range(2 * m):
            covariance[i][i] += noise
        state.amplitude_m = sum([abs(one) for one in phasors])
        slow: list[complex] = (-at.sigma - x[at.decay] + 1j * x[at.frequency]).tolist()
        bias = float(x[at.bias]), float(p[at.bias, at.bias])
        return Merged(phasors, slow, *bias, float(x[at.force]), covariance)


class Present:
    """Phasors Z of the modes at the end of the last block, their covariance, and the value they give.

    force: static deflection by a force that lasts, m. The covariance p is of the phasors' parts, (2m, 2m), and of the
    force after them where there may be one, (2m + 1, 2m + 1).
    """

    def __init__(self, w: list[float], sigma: list[float], w_first: float) -> None:
        """w, sigma: nominal damped frequency, rad/s, and decay rate, 1/s, of each mode."""
        self._w = w
        self._sigma = sigma
        self._per_acceleration = -1.0 / (w_first * w_first)
        self.z = [0j] * len(w)
        self.bias = 0.0
        self.bias_variance = 0.0
        self.force = 0.0
        self.p = [[0.0] * (2 * len(w)) for _ in range(2 * len(w))]
        self.slow = [complex(-one) for one in sigma]
        self.gain = [0j] * len(w)
        self.turn_cycle = [1.0 + 0j] * len(w)

    def restart(
        self,
        z: list[complex],
        p: list[list[float]],
        slow: list[complex],
        bias: float,
        bias_variance: float,
        force: float,
        cycle_s: float,
    ) -> None:
        """From the bank's merged phasors z with covariance p, slow rates, 1/s, accelerometer bias, m, and force, m."""
        self.z, self.p, self.slow, self.force = z, p, slow, force
        self.bias, self.bias_variance = bias, bias_variance
        self.gain = [
            self._per_acceleration * (one + 1j * w) ** 2 for one, w in zip(slow, self._w, strict=True)
        ]
        self.turn_cycle = [exp(one * cycle_s) for one in slow]

    def expected(self, turn: list[complex]) -> float:
        """Expected accelerometer reading, as deflection of the first mode, m, where exp(i w t) is `turn`."""
        total, gain = self.bias, self.gain
        for i, z in enumerate(self.z):
            total += (z * gain[i] * turn[i]).real
        return total

    def uncertain(self, std_m: float) -> bool:
        """Whether what the accelerometer should show is less well known than std_m."""
        total, p = 0.0, self.p
        for i in range(2 * len(self.z)):
            total += p[i][i]
        return total > std_m * std_m

    def advance(self, increment: list[complex]) -> None:
        """One cycle on, in which the joint adds `increment` to the phasors."""
        z, turn_cycle = self.z, self.turn_cycle
        for i, more in enumerate(increment):
            z[i] = z[i] * turn_cycle[i] + more

    def update_by_block(
        self, block: Block, variance: float, shown: tuple[float, float] | None, *, at_end: bool
    ) -> None:
        """Process a block; the phasors stand at its start, or (at_end) at its end. shown: LearntForce.shown."""
        base = block.end_s if at_end else block.start_s
        rows: list[float] = []
        value = self.bias
        for i, turn in enumerate(block.turn):
            seen = self.gain[i] * turn * exp(self.slow[i] * (block.time_s - base))
            z = self.z[i] - block.step[i] if at_end else self.z[i]
            value += (z * seen).real
            rows += (seen.real, seen.imag)
        if len(self.p) > len(rows):
            rows.append(0.0)
        self._update(rows, block.value - block.forced - value, variance + self.bias_variance, shown)

    def residual(self, block: Block) -> float:
        """How far a block, at whose end the phasors stand, lies from what they say, m."""
        value = self.bias
        for i, turn in enumerate(block.turn):
            seen = self.gain[i] * turn * exp(self.slow[i] * (block.time_s - block.end_s))
            value += ((self.z[i] - block.step[i]) * seen).real
        return block.value - block.forced - value

    def _update(
        self, rows: list[float], residual: float, noise: float, shown: tuple[float, float] | None
    ) -> None:
        p = self.p
        if len(p) == 2:
            self._update_one_mode(rows, residual, noise, shown)
            return
        ph = [sum([a * b for a, b in zip(line, rows, strict=True)]) for line in p]
        total = noise + sum([a * b for a, b in zip(ph, rows, strict=True)])
        if shown is not None:
            ph[0] += shown[0]
            ph[1] += shown[1]
        weight = residual / total
        for i, one in enumerate(ph):
            line, share = p[i], one / total
            for j, other in enumerate(ph):
                line[j] -= share * other
        for i in range(len(self.z)):
            self.z[i] += complex(ph[2 * i] * weight, -ph[2 * i + 1] * weight)
        if len(ph) > 2 * len(self.z):
            self.force += ph[-1] * weight

    def _update_one_mode(
        self, rows: list[float], residual: float, noise: float, shown: tuple[float, float] | None
    ) -> None:
        """The same of one mode without a force, written out: it runs for each block and each frame."""
        (cc, cs), (sc, ss) = self.p
        c, s = rows
        at_c, at_s = cc * c + cs * s, sc * c + ss * s
        total = noise + (at_c * c + at_s * s)
        if shown is not None:
            at_c += shown[0]
            at_s += shown[1]
        weight, share_c, share_s = residual / total, at_c / total, at_s / total
        self.p[0][:] = cc - share_c * at_c, cs - share_c * at_s
        self.p[1][:] = sc - share_s * at_c, ss - share_s * at_s
        self.z[0] += complex(at_c * weight, -at_s * weight)

    def move_on(self, block: Block) -> None:
        """From a block's start to its end."""
        dt = block.end_s - block.start_s
        for i, step in enumerate(block.step):
            turn = exp(self.slow[i] * dt)
            self.z[i] = self.z[i] * turn + step * (0.5 + 0.5 * turn)

    def inflate(self, jump: Jump) -> None:
        """FilterBank.inflate."""
        for i, w in enumerate(self._w):
            along = along_rate(w, jump.time_s)
            rest = jump.across_m[i] ** 2
            power = jump.along_m[i] ** 2 - rest
            direction = (along.real, -along.imag)
            for k in (0, 1):
                line = self.p[2 * i + k]
                line[2 * i] += power * direction[k] * direction[0]
                line[2 * i + 1] += power * direction[k] * direction[1]
                line[2 * i + k] += rest
        if jump.force_step_m:
            self.z[0] -= jump.force_step_m * exp(-1j * self._w[0] * jump.time_s)
            self.force += jump.force_step_m
        if jump.force_m and len(self.p) > 2 * len(self.z):
            turn = exp(1j * self._w[0] * jump.time_s)
            moved = {
                0: -turn.real * jump.force_m,
                1: -turn.imag * jump.force_m,
                len(self.p) - 1: jump.force_m,
            }
            for i, one in moved.items():
                for j, other in moved.items():
                    self.p[i][j] += one * other

    def widen(self, variance: float) -> None:
        """Add a variance, m^2, to every component of the phasors."""
        for i in range(2 * len(self.z)):
            self.p[i][i] += variance

    def deflection(self, turn: list[complex]) -> tuple[float, float, float]:
        """Deflection, m, its rate, m/s, and its standard deviation, m, where exp(i w t) is `turn`."""
        q, v, variance = self.force, 0.0, 0.0
        for i, z in enumerate(self.z):
            one = z * turn[i]
            q += one.real
            v += (one * (self.slow[i] + 1j * self._w[i])).real
        p = self.p
        if len(p) == 2:
            c, s = turn[0].real, turn[0].imag
            variance = c * c * p[0][0] + 2.0 * c * s * p[0][1] + s * s * p[1][1]
        else:
            row = [part for one in turn for part in (one.real, one.imag)]
            if len(p) > len(row):
                row.append(1.0)
            variance = quadratic_form(row, p)
        return q, v, 0.0 if variance < 0.0 else sqrt(variance)
