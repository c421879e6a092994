"""The Kalman filter: pure functions from a Gaussian state estimate at one instant (a belief) to another.

A belief refers to the instant of the last measurement, not to the present. A delayed measurement therefore updates the
state at its own time, and nothing has to be undone. A prediction carries the belief to the present, which is exact for
white noise (Anderson and Moore, Optimal Filtering, 1979, section 3.3). If two samples change places, which dating by
time stamps may cause for neighbours, the older one is observed through the later state.

Gating: a measurement far outside its predicted distribution may be wrong by itself, and is skipped. A second one in
succession indicates an impact. The modes' disturbance since the last accepted measurement is then set to the strength
that makes the measurement likely (Jazwinski, Adaptive Filtering, Automatica 5, 1969).
"""

from math import log, sqrt
from typing import NamedTuple

import numpy as np

from stillarm.controller.estimation.kalman.two_time_scales import Matrix, TwoTimeScales, Vector

_GATE_STDS = 4.0  # one false alarm in some minutes at the frame rate
_BATCH_GATE_STDS = 6.0  # the sum of squares has a longer tail than the normal distribution


class Belief(NamedTuple):
    """State and covariance at an instant.

    surprised: the last measurement was outside the gate. log_density: log predictive density of the last scalar
    measurement, without a constant.
    """

    time_s: float
    state: Vector
    covariance: Matrix
    outside_gate: bool = False
    log_density: float = 0.0


def first_belief(model: TwoTimeScales, time_s: float, offset_m: float) -> Belief:
    """The prior at the first sample: no known vibration, and an image zero as the sample shows it."""
    state = np.zeros(model.size)
    state[model.slow] = offset_m
    return Belief(time_s, state, model.prior_covariance())


def predicted(model: TwoTimeScales, belief: Belief, time_s: float) -> Belief:
    """The belief predicted to a later instant; for an earlier instant it is returned unchanged."""
    elapsed = time_s - belief.time_s
    if elapsed <= 0.0:
        return belief
    phi = model.transition(elapsed)
    covariance = phi @ belief.covariance @ phi.T + model.scatter(elapsed)
    return Belief(time_s, phi @ belief.state, covariance)


def seen_from(model: TwoTimeScales, belief: Belief, row: Vector, time_s: float) -> Vector:
    """A sensor's observation row (size,) at an instant before the belief's, expressed in the belief's state."""
    elapsed = time_s - belief.time_s
    return row if elapsed >= 0.0 else row @ model.transition(elapsed)


def updated(
    model: TwoTimeScales,
    belief: Belief,
    row: Vector,
    value: float,
    variance: float,
    impact_within_s: float | None,
) -> Belief:
    """Measurement update with a scalar row @ state + noise.

    impact_within_s: if the measurement is outside the gate, assume an impact within this time (> 0); None: skip it.
    """
    time_s, state, covariance = belief[:3]
    seen = covariance @ row
    innovation = value - float(row @ state)
    spread = float(row @ seen) + variance
    log_density = -0.5 * (innovation * innovation / spread + log(spread))
    outside_gate = innovation * innovation > _GATE_STDS**2 * spread
    if outside_gate:
        if impact_within_s is None:
            return belief._replace(outside_gate=True, log_density=log_density)
        unit = model.scatter_of_modes(impact_within_s)
        covariance = covariance + unit * ((innovation * innovation - spread) / float(row @ unit @ row))
        seen = covariance @ row
        spread = float(row @ seen) + variance
    gain = seen / spread
    left = covariance - np.multiply.outer(gain, seen)
    return Belief(time_s, state + gain * innovation, 0.5 * (left + left.T), outside_gate, log_density)


def updated_by_batch(
    model: TwoTimeScales, belief: Belief, rows: Matrix, values: Vector, impact_within_s: float
) -> Belief:
    """Measurement update with n measurements at once: rows (n, size), values (n,), independent noise of variance 1."""
    time_s, state, covariance = belief[:3]
    residual = values - rows @ state
    information = rows.T @ rows
    count = len(values)
    expected = float(np.vdot(information, covariance))
    excess = float(residual @ residual) - count - expected
    outside_gate = excess > _BATCH_GATE_STDS * sqrt(2.0 * (count + expected * (2.0 + expected)))
    if outside_gate:
        unit = model.scatter_of_modes(impact_within_s)
        covariance = covariance + unit * (excess / float(np.vdot(information, unit)))
    left = np.linalg.solve(model.identity + covariance @ information, covariance)
    left = 0.5 * (left + left.T)
    return Belief(time_s, state + left @ (residual @ rows), left, outside_gate)
