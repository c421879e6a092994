"""What the accelerometer at the tip shows of a motion: its range, gain, bias, delay and lag, and what acts on it.

As a gear's flanks strike it shows a shake of some milliseconds, as stiff as the teeth are. No step of a cycle says when
in it they meet, nor how they give way. Such a sample tells that they struck, which every play foretells, and little
more: a residual there is no longer than noise often is, as far as a strike can reach.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import cont2discrete, lfilter

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.physics.arm_motion import Motion, dead_s
from stillarm.diagnosis.physics.declared_effects import effects_in, laws_at
from stillarm.diagnosis.physics.quantities import (
    ACCELEROMETER_BEGIN,
    GRAVITY_COSINE,
    GRAVITY_SINE,
    GRAVITY_SLOPE,
    LAG_BEND,
    MOST_DOWN,
    MOST_UP,
    OF_ARRIVALS,
    OF_LAST_JUMP,
    RANGE,
)
from stillarm.diagnosis.physics.space import Space
from stillarm.simulation.arm.free_run import reads_later

Array = NDArray[np.float64]

_AS_NOISE = 3.0  # deviations: as far as one normal value in 370 lies
_SHAKES_S = 0.01  # after flanks meet: a shake lasts some milliseconds
_KEPT = ("accelerometer.bias_m_s2", ACCELEROMETER_BEGIN, OF_ARRIVALS)  # the baseline's, or no effect


class Accelerometer:
    """The accelerometer of one recording; `shown` is a pure function of motion and vector."""

    def __init__(self, measured: Measured, space: Space, modes: int, length_m: float) -> None:
        """modes: bending modes of the arm; length_m: its length."""
        self.measured, self.space = measured, space
        self.modes, self.length = modes, length_m
        self.cycle_times: Array = np.arange(measured.cycles, dtype=np.float64) * measured.cycle_s
        self._usual = space.vector()
        self._of_sensor = [
            place
            for name, place in space.place.items()
            if name.startswith("accelerometer.") and name not in _KEPT
        ]

    def shown(self, motion: Motion, vector: Array) -> Array:
        """What it shows, m/s^2, (n,)."""
        at = self.space.place
        begin_s = vector[at[ACCELEROMETER_BEGIN]]
        if begin_s <= 0.0:
            return self._read(motion, vector)
        usual = vector.copy()
        usual[self._of_sensor] = self._usual[self._of_sensor]
        return np.where(self.cycle_times >= begin_s, self._read(motion, vector), self._read(motion, usual))

    def answer(self, acceleration: Array, vector: Array) -> Array | None:
        """What it shows more where the tip moves by that much more, m/s^2, from rest; None where it does not answer
        alike at all times. Within its limits."""
        at = self.space.place
        if vector[at[ACCELEROMETER_BEGIN]] > 0.0:
            return None
        effects = effects_in(vector, at)
        if any(laws_at(effects, where) for where in ("sensitivity", "reading")) or self._feels_angle(vector):
            return None
        late = self._late(acceleration, vector)
        return np.asarray(vector[at["accelerometer.scale"]] * self._lagged(late, vector))

    def is_within_limits(self, shown: Array, vector: Array) -> Array:
        """Where what it shows is not at a limit, (n,) bool."""
        lowest, highest = self._limits(vector)
        return np.asarray((shown > lowest) & (shown < highest))

    def _limits(self, vector: Array) -> tuple[float, float]:
        at = self.space.place
        most = vector[at[RANGE]]
        return -min(most, vector[at[MOST_DOWN]]), min(most, vector[at[MOST_UP]])

    def _late(self, value: Array, vector: Array) -> Array:
        cycles = vector[self.space.place["accelerometer.delay_s"]] / self.measured.cycle_s
        return _late(value, cycles) if cycles > 0.0 else value

    def _lagged(self, value: Array, vector: Array) -> Array:
        at = self.space.place
        lag_s = vector[at["accelerometer.lag_s"]]
        return _lagged(value, self.measured.cycle_s / lag_s, vector[at[LAG_BEND]]) if lag_s > 0.0 else value

    def _read(self, motion: Motion, vector: Array) -> Array:
        """What the accelerometer reads, m/s^2."""
        at = self.space.place
        t = np.maximum(self.cycle_times - vector[at[ACCELEROMETER_BEGIN]], 0.0)
        value = self._late(motion.tip_acceleration + self._of_arrivals(motion, vector), vector)
        if vector[at[OF_LAST_JUMP]]:
            late = int(vector[at["accelerometer.delay_s"]] / self.measured.cycle_s)
            value = value + self._of_last_jump(motion, vector, late)
        value = self._lagged(value, vector)
        gain = vector[at["accelerometer.scale"]]
        effects = effects_in(vector, at)
        for law in laws_at(effects, "sensitivity"):
            gain = gain * law(t)
        value = gain * value + vector[at["accelerometer.bias_m_s2"]]
        for law in laws_at(effects, "reading"):
            value = value + law(t, motion.tip_angle)
        if self._feels_angle(vector):
            theta = motion.joint[:, 0]
            angle = theta + vector[at[GRAVITY_SLOPE]] * (motion.tip_angle - theta)
            value = value + vector[at[GRAVITY_SINE]] * np.sin(angle)
            value = value + vector[at[GRAVITY_COSINE]] * (np.cos(angle) - 1.0)
        shown: Array = np.clip(value, *self._limits(vector))
        return shown

    def _feels_angle(self, vector: Array) -> bool:
        """Whether gravity is felt by the sine or cosine of the sensor's angle."""
        return any(vector[self.space.place[name]] != 0.0 for name in (GRAVITY_SINE, GRAVITY_COSINE))

    def _of_arrivals(self, motion: Motion, vector: Array) -> Array:
        """What the accelerometer reads more or less, m/s^2, where commands arrive as it is read: which comes first by
        some microseconds, no model says."""
        at = self.space.place
        later = reads_later(dead_s(vector, self.space), self.measured.cycle_s)
        share = float(vector[at[OF_ARRIVALS]]) - (1.0 if later else 0.0)
        return np.asarray(share * self._stiff_lever(vector) * motion.joint[:, 3])

    def _of_last_jump(self, motion: Motion, vector: Array, late: int) -> Array:
        """What a late accelerometer reads more of the jump of theta'' between two cycles than interpolation between
        them has of it, m/s^2. It reads before the jump or after, or some of both where its lag is a filter's.

        late: whole cycles of its delay.
        """
        at, alpha = self.space.place, motion.joint[:, 2]
        stays = np.exp(-2.0 * pi * vector[at["drive.bandwidth_hz"]] * self.measured.cycle_s)
        jump = np.zeros(len(alpha))
        jump[late + 1 :] = alpha[1 : len(alpha) - late] - stays * alpha[: len(alpha) - late - 1]
        return np.asarray(vector[at[OF_LAST_JUMP]] * self._stiff_lever(vector) * jump)

    def _stiff_lever(self, vector: Array) -> float:
        """The tip's acceleration by the joint's while no mode has moved, m."""
        at = self.space.place
        rest = 1.0 - sum(float(vector[at[f"modes.{i}.participation"]]) for i in range(self.modes))
        return rest * self.length


def _lagged(values: Array, turns: float, bend: float) -> Array:
    """Values behind a filter 1 / (1 + lag s + bend (lag s)^2), of a lag of 1/turns samples, exact for a ramp between
    them. bend: 0 is of first order."""
    start = values[0]
    if bend > 0.0:
        lag = 1.0 / turns
        above, below, _ = cont2discrete(([1.0], [bend * lag * lag, lag, 1.0]), 1.0, method="foh")
        return np.asarray(start + lfilter(above[0], below, values - start))
    stays = np.exp(-turns)
    now = 1.0 - (1.0 - stays) / turns
    before = (1.0 - stays) / turns - stays
    return np.asarray(start + lfilter([now, before], [1.0, -stays], values - start))


def _late(values: Array, cycles: float) -> Array:
    """Values `cycles` earlier, by Lagrange's cubic; before the first sample the first."""
    n = len(values)
    whole = int(np.floor(cycles))
    f = cycles - whole
    padded = np.concatenate((np.full(whole + 2, values[0]), values, (values[-1],)))
    base = np.arange(n) + 2  # of values[k - whole] in padded: k - whole + whole + 2
    newer, now, older, oldest = padded[base + 1], padded[base], padded[base - 1], padded[base - 2]
    between: Array = (
        newer * (-f * (1.0 - f) * (2.0 - f) / 6.0)
        + now * ((1.0 + f) * (1.0 - f) * (2.0 - f) / 2.0)
        + older * ((1.0 + f) * f * (2.0 - f) / 2.0)
        - oldest * ((1.0 + f) * f * (1.0 - f) / 6.0)
    )
    return between


def without_strikes(residual: Array, omega: Array, length_m: float, noise: float, step_s: float) -> Array:
    """An accelerometer's residual, m/s^2, (n,), less what strikes may have added to it.

    omega: (n,) velocity of the joint behind the gear, rad/s: it rests between the flanks, and jumps as they meet.
    length_m: of the arm, of which no more shakes than all of it as one.
    """
    struck = np.flatnonzero((omega[1:] != 0.0) != (omega[:-1] != 0.0)) + 1
    reach = np.zeros(len(omega))
    jump = np.abs(length_m * (omega[struck] - omega[struck - 1])) / step_s
    for later in range(-1, round(_SHAKES_S / step_s)):
        at = np.clip(struck + later, 0, len(omega) - 1)
        np.maximum.at(reach, at, jump)
    most = _AS_NOISE * noise
    long = np.clip(np.abs(residual) - most, 0.0, reach)
    return np.asarray(residual - np.sign(residual) * long)
