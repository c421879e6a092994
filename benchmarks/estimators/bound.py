"""The least possible errors of delay and deflection: the Bayesian Cramer-Rao bound along a trial.

The unknowns are the generator's random quantities. Each measurement is linearised at the truth, so that the posterior
covariance of a Gaussian problem follows from a Riccati recursion over the frames in the order of their reading
(van Trees, Detection, Estimation, and Modulation Theory, part I, 2.4; Tichavsky, Muravchik and Nehorai, Posterior
Cramer-Rao bounds for discrete-time nonlinear filtering, 1998). docs/benchmark-estimators.md derives it.
"""

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.estimators.world.generator import Data, cycle_times
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, DRIFT_TIME_S, FRAME_S, Regime

Values = NDArray[np.float64]

# The unknowns, as deviations from the truth. The mode's state is expressed at time zero by free motion, so that it is
# constant between impacts. The second state is that from before the last impact, for frames exposed before it.
_NOW, _BEFORE = slice(0, 2), slice(2, 4)
_ZERO = 4  # image zero, m
_EXPOSED = 5  # mid-exposure of the present frame, s
_BASE, _SKEW, _WALK_OF_EXPOSURE = 6, 7, 8  # frame clock; slow part of the exposure's irregularity
_MEAN, _WALK_OF_DELAY = 9, 10  # of the delay
_AHEAD = 11  # time from n_i to mid-exposure
_STAMP_ZERO, _STAMP_RATE = 12, 13
_STATES = 14
_STEP_S = 1e-5  # of a difference quotient
_WIDE_S = 0.1  # wide against milliseconds: no prior knowledge


@dataclass(frozen=True)
class Bound:
    """Posterior standard deviations of delay and deflection just after each frame is read. Shape (frames,)."""

    delay_std_s: Values
    deflection_std_m: Values


def bound(data: Data) -> Bound:
    """The bound for each frame of a trial, from all measurements up to its reading."""
    regime, frames, impacts = data.regime, data.frames, data.motion.impacts_s
    covariance = _prior(data)
    sums = _acceleration_information(data)
    transition, growth = _frame_step(regime)
    deviation = np.empty((2, len(frames.number)))
    truth = data.motion.at(frames.exposed_s)
    cycle, struck, number = 0, 0, int(frames.number[0])
    first = True
    for k, read in enumerate(frames.read_cycle):
        while struck < len(impacts) and impacts[struck] < read * CYCLE_S:
            at = int(impacts[struck] / CYCLE_S)
            covariance = _informed(covariance, sums[at] - sums[cycle])
            covariance = _struck(covariance, data, struck)
            cycle, struck = at, struck + 1
        covariance = _informed(covariance, sums[read] - sums[cycle])
        cycle = int(read)
        for _ in range(int(frames.number[k]) - number):
            covariance = transition @ covariance @ transition.T + growth
        number = int(frames.number[k])
        if first:
            covariance[_EXPOSED, :] = covariance[_BASE, :] + covariance[_WALK_OF_EXPOSURE, :]
            covariance[:, _EXPOSED] = covariance[:, _BASE] + covariance[:, _WALK_OF_EXPOSURE]
            white = regime.jitter_s**2 if regime.triggered else 0.0
            covariance[_EXPOSED, _EXPOSED] = (
                covariance[_EXPOSED, _BASE] + covariance[_EXPOSED, _WALK_OF_EXPOSURE] + white
            )
            first = False
        exposed = float(frames.exposed_s[k])
        for row, variance in _time_measurements(regime, exposed):
            covariance = _measured(covariance, row, variance)
        row = np.zeros(_STATES)
        segment = _BEFORE if struck and exposed < impacts[struck - 1] else _NOW
        row[segment] = _free_motion(data, np.array([exposed]))[0, 0]
        row[_EXPOSED], row[_ZERO] = truth[1][k], 1.0
        covariance = _measured(covariance, row, (data.arm.vision_noise * data.arm.amplitude_m) ** 2)
        deviation[0, k] = sqrt(covariance[_EXPOSED, _EXPOSED])
        present = _free_motion(data, np.array([read * CYCLE_S]))[0, 0]
        deviation[1, k] = sqrt(present @ covariance[_NOW, _NOW] @ present)
    return Bound(*deviation)


def _prior(data: Data) -> Values:
    arm, regime = data.arm, data.regime
    rate = (1e-6 * regime.skew_ppm) ** 2 / 3.0
    variance = np.zeros(_STATES)
    variance[0] = variance[2] = arm.amplitude_m**2
    variance[1] = variance[3] = (arm.angular_frequency * arm.amplitude_m) ** 2
    variance[_ZERO] = (2.0 * arm.amplitude_m) ** 2
    variance[_BASE] = _WIDE_S**2
    variance[_SKEW] = rate
    variance[_WALK_OF_EXPOSURE] = regime.drift_s**2 if regime.triggered else 0.0
    variance[_MEAN] = regime.delay_prior_s**2
    variance[_WALK_OF_DELAY] = regime.drift_s**2
    variance[_AHEAD] = regime.started_offset_s**2 / 3.0
    variance[_STAMP_ZERO] = _WIDE_S**2
    variance[_STAMP_RATE] = rate
    covariance = np.diag(variance)
    covariance[_BEFORE, _NOW] = covariance[_NOW, _BEFORE] = covariance[_NOW, _NOW]
    return covariance


def _frame_step(regime: Regime) -> tuple[Values, Values]:
    """Transition and added covariance from one exposure to the next."""
    keep = exp(-FRAME_S / DRIFT_TIME_S)
    step = np.eye(_STATES)
    step[_BASE, _SKEW] = FRAME_S
    step[_WALK_OF_EXPOSURE, _WALK_OF_EXPOSURE] = step[_WALK_OF_DELAY, _WALK_OF_DELAY] = keep
    step[_EXPOSED, :] = step[_BASE, :] + step[_WALK_OF_EXPOSURE, :]
    noise = np.zeros((_STATES, _STATES))
    slow = regime.drift_s**2 * (1.0 - keep * keep)
    noise[_WALK_OF_DELAY, _WALK_OF_DELAY] = slow
    if regime.triggered:
        walk = regime.trigger_walk_s**2
        noise[_BASE, _BASE] = noise[_BASE, _EXPOSED] = noise[_EXPOSED, _BASE] = walk
        noise[_WALK_OF_EXPOSURE, _WALK_OF_EXPOSURE] = slow
        noise[_WALK_OF_EXPOSURE, _EXPOSED] = noise[_EXPOSED, _WALK_OF_EXPOSURE] = slow
        noise[_EXPOSED, _EXPOSED] = walk + slow + regime.jitter_s**2
    return step, noise


def _time_measurements(regime: Regime, exposed_s: float) -> list[tuple[Values, float]]:
    """Rows and variances of the arrival, of n_i and of the camera's stamp.

    For a busy computer the bound knows how long each image waited in the queue. No estimator can know that; the rest of
    the delay is Gaussian. n_i is then the end of an earlier image, and adds nothing.
    """
    rounding = CYCLE_S**2 / 12.0
    arrival, started, stamp = np.zeros((3, _STATES))
    arrival[[_EXPOSED, _MEAN, _WALK_OF_DELAY]] = 1.0
    if regime.busy is not None:
        return [(arrival, rounding)]
    started[[_EXPOSED, _AHEAD]] = 1.0, -1.0
    stamp[[_EXPOSED, _STAMP_ZERO, _STAMP_RATE]] = 1.0, 1.0, exposed_s
    rows = [(arrival, regime.jitter_s**2 + rounding), (started, regime.started_white_s**2 + rounding)]
    return [*rows, (stamp, regime.stamp_s**2)] if regime.stamped else rows


def _free_motion(data: Data, time_s: Values) -> Values:
    """Transition of deflection and rate from time zero to those times, shape (times, 2, 2)."""
    w, zeta = data.arm.angular_frequency, data.arm.damping_ratio
    damped = w * sqrt(1.0 - zeta * zeta)
    decay, c, s = np.exp(-zeta * w * time_s), np.cos(damped * time_s), np.sin(damped * time_s)
    lean = zeta * w / damped
    rows = np.array([[c + lean * s, s / damped], [-w * w * s / damped, c - lean * s]])
    return np.asarray((decay * rows).transpose(2, 0, 1))


def _acceleration_information(data: Data) -> Values:
    """Cumulative Fisher information on the mode's state before each cycle, shape (cycles + 1, 2, 2).

    Samples during an impact inform about the impact (_struck) and are left out here.
    """
    arm = data.arm
    w = arm.angular_frequency
    time_s = cycle_times(len(data.acceleration_m_s2))
    row = np.array([-w * w, -2.0 * arm.damping_ratio * w]) @ _free_motion(data, time_s)
    quiet = np.ones(len(time_s))
    for impact in data.motion.impacts_s:
        quiet[np.abs(time_s - impact) <= 0.5 * arm.impact_s] = 0.0
    noise = data.noise * w * w * arm.amplitude_m
    each = quiet[:, None, None] * row[:, :, None] * row[:, None, :] / noise**2
    return np.concatenate([np.zeros((1, 2, 2)), np.cumsum(each, axis=0)])


def _informed(covariance: Values, information: Values) -> Values:
    """The covariance after adding `information`, shape (2, 2), on the present state."""
    across = covariance[:, _NOW]
    inner = np.linalg.inv(np.eye(2) + information @ covariance[_NOW, _NOW])
    reduced = covariance - across @ inner @ information @ across.T
    return 0.5 * (reduced + reduced.T)


def _struck(covariance: Values, data: Data, impact: int) -> Values:
    """The covariance after an impact that the accelerometer has measured while it lasted.

    The samples determine its size to the noise of their sum, and its instant to a cycle at best: a constant force that
    lasts a whole number of cycles may begin anywhere within a cycle without changing any sample.
    """
    copy = np.eye(_STATES)
    copy[_BEFORE, _BEFORE], copy[_BEFORE, _NOW] = 0.0, np.eye(2)
    covariance = copy @ covariance @ copy.T
    arm, impact_s = data.arm, float(data.motion.impacts_s[impact])
    noise = data.noise * arm.angular_frequency**2 * arm.amplitude_m
    shown = noise**2 * CYCLE_S * arm.impact_s
    size = 1.0 / (1.0 / arm.impact_std_m_s**2 + 1.0 / shown)
    before, kick, behind = (_kick(data, impact_s + step) for step in (-_STEP_S, 0.0, _STEP_S))
    by_instant = (behind - before) / (2.0 * _STEP_S) * data.motion.impact_velocity_m_s[impact]
    covariance[_NOW, _NOW] += size * np.outer(kick, kick)
    covariance[_NOW, _NOW] += CYCLE_S**2 / 12.0 * np.outer(by_instant, by_instant)
    return covariance


def _kick(data: Data, time_s: float) -> Values:
    """Change of the state at time zero by a unit of velocity added at that time, shape (2,)."""
    return np.asarray(np.linalg.inv(_free_motion(data, np.array([time_s]))[0])[:, 1])


def _measured(covariance: Values, row: Values, variance: float) -> Values:
    seen = covariance @ row
    reduced = covariance - np.outer(seen, seen) / (row @ seen + variance)
    return 0.5 * (reduced + reduced.T)
