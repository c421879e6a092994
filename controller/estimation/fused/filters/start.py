"""The filters' prior, and how fast their knowledge ages.

Implements Eqs. 29, 47 of docs/fused.md.
"""

from math import hypot

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAWS, LEVELS, Law

Array = NDArray[np.float64]


def frame_s(model: Model) -> float:
    """Nominal period of the frames, s."""
    return 1.0 / model.camera.frame_rate_hz


def spread_s(model: Model, assumed: Assumptions = ASSUMPTIONS) -> float:
    """Spread of the capture delay from frame to frame and over time, s."""
    return max(model.timing.capture_delay_std_s, assumed.start.least_spread_s)


def first_shift_s(model: Model, assumed: Assumptions = ASSUMPTIONS) -> float:
    """How far the first frame's instant may lie from arrival minus the model's delay: a stale frame is in it."""
    return hypot(spread_s(model, assumed), assumed.start.stale_frames * frame_s(model), assumed.start.stale_s)


def variances(
    model: Model, settings: Fused, at: Layout, length_m: float, assumed: Assumptions = ASSUMPTIONS
) -> Array:
    """Variances of the state at the start, (filters, n)."""
    v = np.zeros((LAWS, at.size))
    v[:, at.phasor] = (assumed.start.amplitude * length_m) ** 2
    v[:, at.frequency] = (settings.frequency_spread * at.w) ** 2
    v[:, at.decay] = (assumed.start.decay_share * at.sigma + assumed.start.decay_w * at.w) ** 2
    v[:, at.offset] = (assumed.start.image_zero * length_m) ** 2
    v[:, at.scale] = assumed.start.scale**2
    v[:, at.bias] = (assumed.start.bias_m_s2 / at.w_first**2) ** 2
    v[:, at.shift] = first_shift_s(model, assumed) ** 2
    for law in (Law.CLOCK, Law.STAMPS):
        v[law, at.skew] = assumed.start.skew**2
        v[law, at.late] = first_shift_s(model, assumed) ** 2
    v[:, at.ahead] = (assumed.start.ahead_frames * frame_s(model)) ** 2
    v[Law.DRIFT, at.late] = (assumed.start.late_share * spread_s(model, assumed)) ** 2
    return np.tile(v, (LEVELS, 1))


def jitters_s(model: Model, assumed: Assumptions = ASSUMPTIONS) -> Array:
    """White spread of each filter's instants, s, (filters,)."""
    result = np.zeros(LAWS)
    result[Law.CLOCK], result[Law.STAMPS] = assumed.start.clock_s, assumed.start.stamp_s
    result[Law.STEADY], result[Law.DRIFT], result[Law.JITTER] = (
        assumed.start.steady_s,
        assumed.start.drift_s,
        spread_s(model, assumed),
    )
    return np.tile(result, LEVELS)


def shift_noise(model: Model, assumed: Assumptions = ASSUMPTIONS) -> Array:
    """Growth of the variance of each filter's shift, s^2 per s, (filters,)."""
    result = np.zeros(LAWS)
    result[Law.CLOCK] = result[Law.STAMPS] = assumed.start.clock_walk_s**2
    result[Law.STEADY], result[Law.JITTER] = assumed.start.steady_walk_s**2, assumed.start.jitter_walk_s**2
    result[Law.DRIFT] = 2.0 * assumed.start.drift_return * spread_s(model, assumed) ** 2
    return np.tile(result, LEVELS)


def shift_return(assumed: Assumptions = ASSUMPTIONS) -> Array:
    """Rate at which each filter's shift comes back to its mean, 1/s, (filters,)."""
    result = np.zeros(LAWS)
    result[Law.DRIFT] = assumed.start.drift_return
    return np.tile(result, LEVELS)


def state_noise(settings: Fused, at: Layout, assumed: Assumptions = ASSUMPTIONS) -> Array:
    """Growth of the variances of all but the phasors, per s, (filters, n)."""
    result = np.zeros((FILTERS, at.size))
    quiet, disturbed = slice(0, LAWS), slice(LAWS, None)
    for level, looser in ((quiet, 1.0), (disturbed, assumed.start.looser)):
        result[level, at.offset] = (assumed.start.offset_walk * looser) ** 2
        result[level, at.scale] = (assumed.start.scale_walk * looser) ** 2
        result[level, at.bias] = (assumed.start.bias_walk_m_s2 * looser / at.w_first**2) ** 2
    result[quiet, at.frequency] = (settings.frequency_walk * at.w) ** 2
    result[disturbed, at.frequency] = (assumed.start.disturbed_walk * settings.frequency_walk * at.w) ** 2
    result[quiet, at.decay] = (assumed.start.decay_walk * at.w) ** 2
    result[disturbed, at.decay] = (assumed.start.disturbed_decay_walk * at.w) ** 2
    return result


def phasor_share(settings: Fused, assumed: Assumptions = ASSUMPTIONS) -> Array:
    """Growth of the phasors' deviation as a share of the amplitude, squared, per s, (filters,)."""
    result = np.full(FILTERS, settings.disturbance_share**2)
    result[LAWS:] *= assumed.start.disturbed_share**2
    return result


def beliefs(model: Model, assumed: Assumptions = ASSUMPTIONS) -> Array:
    """Logarithm of the probability of each filter's law before anything is seen, (filters,)."""
    clock = assumed.start.freerun_clock if model.camera.mode == "freerun" else assumed.start.triggered_clock
    rest = (1.0 - clock) / 3.0
    laws = np.log(np.array((clock, 1e-300, rest, rest, rest)))
    result: Array = np.tile(laws, LEVELS)
    return result
