"""What a baseline's own parameters could take up of a change: frequency, damping and participation of each mode, how
the first began, how hard the tip was struck or pulled, image scale and offset, mean delay, bias of the accelerometer.

The linear arm at the joint's true motion, a value a cycle, every mode in closed form: with y = q' - s* q and
s = -z w + i w sqrt(1 - z^2),

    y' = s y + f,    q = Im(y) / Im(s),    f = - p L theta'' + push F,    f constant within a cycle

Only differences between two sets of parameters are used, so that what the coarse steps leave out falls away. Least
squares over acceleration and displacement, each over its noise, by Levenberg's and Marquardt's method from the true
parameters on: a local minimum. Where phases slip by whole periods it may take up less than a global search would.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.hidden_world.rigs.motion import Motion
from tests.hidden_world.rigs.moves import TIP, Move, tip_force
from tests.hidden_world.rigs.recording import Recording
from tests.hidden_world.rigs.rig import FINE, STEP_S, TICK_S, Rig, Values

_TRIALS = 8
_GAINS_ENOUGH = 0.01
_RELATIVE = 1e-4
"""A parameter's step for its derivative; parameters are relative to what they change."""


@dataclass(frozen=True)
class Linear:
    """A rig's plain arm. forces: of each move at the tip, mean over each cycle and value at its beginning."""

    rig: Rig
    joint_m_s2: Values
    joint_before_m_s2: Values
    path_m: Values
    forces: list[tuple[Values, Values]]
    at_s: Values

    @property
    def count(self) -> int:
        return 3 * len(self.rig.modes) + 2 + len(self.forces) + 4

    def sensors(self, p: Values) -> tuple[Values, Values]:
        """Acceleration and displacement with the parameters changed by p, shape (count,)."""
        rig, k = self.rig, 3 * len(self.rig.modes)
        mean, first = np.zeros(rig.cycles), np.zeros(rig.cycles)
        for number, (each_mean, each_first) in enumerate(self.forces):
            mean = mean + (1.0 + p[k + 2 + number]) * each_mean
            first = first + (1.0 + p[k + 2 + number]) * each_first
        usual = rig.fastest_rad_s * rig.length_m / (2.0 * np.pi * rig.modes[0].frequency_hz)
        s, acceleration = self.path_m, self.joint_before_m_s2
        for i, mode in enumerate(rig.modes):
            w = 2.0 * np.pi * mode.frequency_hz * (1.0 + p[3 * i])
            z, share = mode.damping_ratio * np.exp(p[3 * i + 1]), mode.participation * (1.0 + p[3 * i + 2])
            start = (p[k] * usual, p[k + 1] * usual * w) if i == 0 else (0.0, 0.0)
            if i == 0 and rig.swinging_m:
                start = (
                    start[0] + rig.swinging_m * np.cos(rig.swinging_phase),
                    start[1] + rig.swinging_m * np.sin(rig.swinging_phase) * w,
                )
            q, v = _mode(w, z, mode.push * mean - share * self.joint_m_s2, *start)
            s = s + q
            f = mode.push * first - share * self.joint_before_m_s2
            acceleration = acceleration + f - 2.0 * z * w * v - w * w * q
        scale, offset, late, bias = p[-4:]
        px = -rig.camera.scale_px_per_m * (1.0 + scale) * self._seen(s, late) + rig.camera.noise_px * offset
        sensor = rig.accelerometer
        felt = (sensor.scale * acceleration + sensor.noise_m_s2 * bias) if sensor else acceleration[:0]
        return np.asarray(felt), np.asarray(px)

    def _seen(self, s: Values, late: float) -> Values:
        t = np.arange(len(s)) * TICK_S
        integral = np.concatenate(([0.0], np.cumsum(0.5 * (s[1:] + s[:-1]) * TICK_S)))
        half, at = 0.5 * self.rig.camera.exposure_s, self.at_s + late * self.rig.arrival.std_s
        return np.asarray(
            (np.interp(at + half, t, integral) - np.interp(at - half, t, integral)) / (2.0 * half)
        )


# a trial past critical damping has a cost that is no number, and is refused
@np.errstate(divide="ignore", invalid="ignore")
def _mode(w: float, z: float, force: Values, q0: float, v0: float) -> tuple[Values, Values]:
    s = complex(-z * w, w * np.sqrt(1.0 - z * z))
    turn = np.exp(s * TICK_S)
    start = v0 - s.conjugate() * q0
    drive = np.concatenate(([start], (turn - 1.0) / s * force[:-1]))
    y = lfilter([1.0], [1.0, -turn], drive)
    q = np.imag(y) / s.imag
    return q, np.real(y) - z * w * q


def linear(rig: Rig, moves: list[Move], motion: Motion, at_s: Values) -> Linear:
    """The plain arm of a rig at the joint's motion; at_s: middles of exposures."""
    fast = motion.link_rad_s
    mean = np.diff(fast[::FINE])[: rig.cycles] / TICK_S
    before = np.concatenate(([0.0], (fast[FINE::FINE] - fast[FINE - 1 :: FINE][: rig.cycles]) / STEP_S))[
        : rig.cycles
    ]
    forces = []
    for move in moves:
        if move.kind in TIP:
            force = tip_force([move], rig.steps)
            each = force[: 2 * rig.steps].reshape(rig.cycles, 2 * FINE)
            forces.append((np.mean(each, axis=1), each[:, 0]))
    length = rig.length_m
    return Linear(
        rig, length * mean, length * before, length * motion.link_rad[::FINE][: rig.cycles], forces, at_s
    )


def taken_up(changed: Recording, plain: Recording, moves: list[Move]) -> tuple[Values | None, Values]:
    """What plain parameters could make of the plain recording's acceleration (a value a cycle) and displacement (a
    value for each exposure that both recordings hold). Both noise-free, of one rig."""
    rig = plain.rig
    _, here, there = np.intersect1d(changed.images.index, plain.images.index, return_indices=True)
    arm = linear(rig, moves, plain.motion, plain.images.middle_s[there])
    sensor, weights, wanted = rig.accelerometer, [], []
    if sensor and plain.acceleration is not None and changed.acceleration is not None:
        free = np.abs(plain.acceleration) < 0.97 * sensor.range_m_s2
        weights.append(free / sensor.noise_m_s2)
        wanted.append(changed.acceleration - plain.acceleration)
    weights.append(np.full(len(there), 1.0 / rig.camera.noise_px))
    wanted.append(changed.px[here] - plain.px[there])
    weight, target = np.concatenate(weights), np.concatenate(wanted)
    gained = _fitted(arm, weight, target)
    if sensor and plain.acceleration is not None:
        limit = sensor.range_m_s2
        return np.clip(plain.acceleration + gained[: rig.cycles], -limit, limit), plain.px[there] + gained[
            rig.cycles :
        ]
    return None, plain.px[there] + gained


def _fitted(arm: Linear, weight: Values, target: Values) -> Values:
    """The change of the sensors that comes nearest to the target."""
    p = np.zeros(arm.count)
    base = np.concatenate(arm.sensors(p))
    now, gained = base, np.zeros(len(base))
    cost, damping = _cost(weight, target), 1e-6
    slopes: NDArray[np.float64] | None = None
    for _ in range(_TRIALS):
        if slopes is None:
            slopes = _slopes(arm, p, now, weight)
            normal, pull = slopes.T @ slopes, slopes.T @ (weight * (target - gained))
        scale = np.diag(normal) + 1e-12
        step = np.linalg.lstsq(normal + damping * np.diag(scale), pull, rcond=1e-12)[0]
        step = np.clip(step, -0.3, 0.3) if np.max(np.abs(step[: 3 * len(arm.rig.modes)])) > 0.3 else step
        then = np.concatenate(arm.sensors(p + step))
        new = _cost(weight, target - (then - base))
        if new < cost:
            enough = cost - new < _GAINS_ENOUGH * cost or new < 1e-3 * len(target)
            p, now, gained, cost, slopes = p + step, then, then - base, new, None
            damping = max(0.1 * damping, 1e-9)
            if enough:
                break
        else:
            damping = max(30.0 * damping, 1e-4)
    return gained


def _cost(weight: Values, rest: Values) -> float:
    return float(np.sum((weight * rest) ** 2))


def _slopes(arm: Linear, p: Values, now: Values, weight: Values) -> Values:
    out = np.empty((len(now), len(p)))
    for k in range(len(p)):
        moved = p.copy()
        moved[k] += _RELATIVE
        out[:, k] = weight * (np.concatenate(arm.sensors(moved)) - now) / _RELATIVE
    return out
