"""What the filters believe before the first measurement, and how fast what they know ages."""

from math import hypot

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import Fused
from stillarm.common.files.model import Model
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.filters.laws import FILTERS, LAWS, LEVELS, Law

Array = NDArray[np.float64]

_FIRST_AMPLITUDE = 0.02  # of the arm's length
_IMAGE_ZERO = 0.05  # of the arm's length, about the first image
_SCALE = 0.07
_BIAS_M_S2 = 1.0
SKEW = 60e-6  # two crystals, each some tens of ppm off; 200 ppm lies within three and a half deviations
_STEADY_S, _DRIFT_S, _CLOCK_S, _STAMP_S = 0.0003, 0.0005, 0.00002, 0.00004
AHEAD_FRAMES = 1.0  # n_i before mid-exposure: half a frame, a whole one, or two
_LEAST_DELAY_SPREAD_S = 0.002
DISTURBED = 0.2  # probability of that level before anything is seen
_DISTURBED_WALK, _DISTURBED_SHARE = 150.0, 22.0  # of the disturbed level, by what the quiet one allows
_DRIFT_RETURN = 0.35  # 1/s: the delay wanders over its spread in some seconds


def frame_s(model: Model) -> float:
    """Nominal period of the frames, s."""
    return 1.0 / model.camera.frame_rate_hz


def spread_s(model: Model) -> float:
    """Spread of the capture delay from frame to frame and over time, s."""
    return max(model.timing.capture_delay_std_s, _LEAST_DELAY_SPREAD_S)


def first_shift_s(model: Model) -> float:
    """How far the first frame's instant may lie from arrival minus the model's delay: a stale frame is in it."""
    return hypot(spread_s(model), 0.5 * frame_s(model), 0.03)


def variances(model: Model, settings: Fused, at: Layout, length_m: float) -> Array:
    """Variances of the state at the start, (filters, n)."""
    v = np.zeros((LAWS, at.size))
    v[:, at.phasor] = (_FIRST_AMPLITUDE * length_m) ** 2
    v[:, at.frequency] = (settings.frequency_spread * at.w) ** 2
    v[:, at.decay] = (0.5 * at.sigma + 0.002 * at.w) ** 2
    v[:, at.offset] = (_IMAGE_ZERO * length_m) ** 2
    v[:, at.scale] = _SCALE**2
    v[:, at.bias] = (_BIAS_M_S2 / at.w_first**2) ** 2
    v[:, at.shift] = first_shift_s(model) ** 2
    for law in (Law.CLOCK, Law.STAMPS):
        v[law, at.skew] = SKEW**2
        v[law, at.late] = first_shift_s(model) ** 2
    v[:, at.ahead] = (AHEAD_FRAMES * frame_s(model)) ** 2
    v[Law.DRIFT, at.late] = (0.5 * spread_s(model)) ** 2
    return np.tile(v, (LEVELS, 1))


def jitters_s(model: Model) -> Array:
    """White spread of each filter's instants, s, (filters,)."""
    result = np.zeros(LAWS)
    result[Law.CLOCK], result[Law.STAMPS] = _CLOCK_S, _STAMP_S
    result[Law.STEADY], result[Law.DRIFT], result[Law.JITTER] = _STEADY_S, _DRIFT_S, spread_s(model)
    return np.tile(result, LEVELS)


def shift_noise(model: Model) -> Array:
    """Growth of the variance of each filter's shift, s^2 per s, (filters,)."""
    result = np.zeros(LAWS)
    result[Law.CLOCK] = result[Law.STAMPS] = 1e-6**2
    result[Law.STEADY], result[Law.JITTER] = 3e-5**2, 2e-4**2
    result[Law.DRIFT] = 2.0 * _DRIFT_RETURN * spread_s(model) ** 2
    return np.tile(result, LEVELS)


def shift_return() -> Array:
    """Rate at which each filter's shift comes back to its mean, 1/s, (filters,)."""
    result = np.zeros(LAWS)
    result[Law.DRIFT] = _DRIFT_RETURN
    return np.tile(result, LEVELS)


def state_noise(settings: Fused, at: Layout) -> Array:
    """Growth of the variances of all but the phasors, per s, (filters, n)."""
    result = np.zeros((FILTERS, at.size))
    quiet, disturbed = slice(0, LAWS), slice(LAWS, None)
    for level, looser in ((quiet, 1.0), (disturbed, 2.0)):
        result[level, at.offset] = (1e-5 * looser) ** 2
        result[level, at.scale] = (1e-4 * looser) ** 2
        result[level, at.bias] = (0.015 * looser / at.w_first**2) ** 2
    result[quiet, at.frequency] = (settings.frequency_walk * at.w) ** 2
    result[disturbed, at.frequency] = (_DISTURBED_WALK * settings.frequency_walk * at.w) ** 2
    result[quiet, at.decay] = (0.000015 * at.w) ** 2
    result[disturbed, at.decay] = (0.006 * at.w) ** 2
    return result


def phasor_share(settings: Fused) -> Array:
    """Growth of the phasors' deviation as a share of the amplitude, squared, per s, (filters,)."""
    result = np.full(FILTERS, settings.disturbance_share**2)
    result[LAWS:] *= _DISTURBED_SHARE**2
    return result


def beliefs(model: Model) -> Array:
    """Logarithm of the probability of each filter's law before anything is seen, (filters,)."""
    clock = 0.75 if model.camera.mode == "freerun" else 0.1
    rest = (1.0 - clock) / 3.0
    laws = np.log(np.array((clock, 1e-300, rest, rest, rest)))
    result: Array = np.tile(laws, LEVELS)
    return result
