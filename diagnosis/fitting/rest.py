"""What a fit leaves in the channels: how much, whether it matters, and what a perfect model would gain."""

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import MATTERS_OF_NOISE
from stillarm.diagnosis.data.robust import without_spikes
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.channel_noise import at_a_limit, least_that_matters, noise_of, white_noise
from stillarm.diagnosis.fitting.evidence import score, score_of_noise
from stillarm.diagnosis.fitting.fitted import THIN, Fit

Array = NDArray[np.float64]

_SPIKED = "acceleration"  # the channel in which impulse noise is looked for
_NEAR_THE_LIMIT = 0.5  # of it: what reads its limit though less is foretold is no matter of the limit


@dataclass(frozen=True)
class Rest:
    """What is left in a channel. rms: beyond the noise, in the channel's unit; share_of_noise; immaterial."""

    channel: str
    rms: float
    share_of_noise: float
    immaterial: bool
    band_hz: tuple[float, float]


def explainable(last: Fit, split: Split) -> dict[str, float]:
    """Nats that a perfect model would gain on a fit, by channel: all but the channel's own noise, and but for what is
    too little to matter. A fine encoder has next to no noise: no user asks for a model as good as that. Nor does any
    model foretell a lone spike, which is a matter of laws."""
    last = _without_spikes(last)
    now = score(last, split)
    found = {}
    for name in last.residuals:
        of_mean = 1.0 / sqrt(THIN.get(name, 1))
        noise, matters = of_mean * white_noise(last, name), of_mean * least_that_matters(last, name)
        ideal = score_of_noise(last, name, split, noise, matters)
        found[name] = max(ideal - float(now.whole[name].sum()), 0.0)
    return found


def _without_spikes(last: Fit) -> Fit:
    """A fit without the lone spikes of its accelerometer's residual."""
    residual = last.residuals.get(_SPIKED)
    if residual is None:
        return last
    # at a limit hardly any noise is left, beside which that of the other samples were all spikes; but a spike may reach
    # the limit as well, where the simulation does not
    foretold, read = last.predicted.channels[_SPIKED], last.world.channels[_SPIKED]
    limited = at_a_limit(last) & (np.abs(foretold) > _NEAR_THE_LIMIT * np.abs(read))
    clean = np.where(limited, residual, without_spikes(np.where(limited, np.nan, residual)))
    return replace(last, residuals={**last.residuals, _SPIKED: clean})


def anything_matters(last: Fit, split: Split) -> bool:
    """Whether a fit leaves anything that a user would care about (contract.md)."""
    return any(not rest_of(last, name, split).immaterial for name in last.residuals)


def anything_but_spikes_matters(last: Fit, split: Split) -> bool:
    """The same of all but lone spikes of the accelerometer: whether these have a law is no matter of any fit."""
    return anything_matters(_without_spikes(last), split)


def rest_of(last: Fit, name: str, split: Split) -> Rest:
    """What a fit leaves in a channel beyond its noise."""
    rms, noise = _beyond_noise(last, name, split)
    immaterial = rms < MATTERS_OF_NOISE * noise or rms < least_that_matters(last, name)
    residual = last.residuals[name]
    band = _band(residual[np.isfinite(residual)], last.world.step_s(name))
    return Rest(name, rms, rms / noise if noise > 0.0 else 0.0, immaterial, band)


def _beyond_noise(last: Fit, name: str, split: Split) -> tuple[float, float]:
    """The rms of what a fit leaves in a channel beyond its noise, and that noise."""
    residual = last.residuals[name]
    known = residual[np.isfinite(residual) & ~_walked(last, name, split)]
    noise = noise_of(last, name, split)
    return sqrt(max(float(np.mean(known**2)) - noise**2, 0.0)) if len(known) else 0.0, noise


def _walked(last: Fit, name: str, split: Split) -> NDArray[np.bool_]:
    """Samples of a channel that are held out from a random walk, (samples,). Nobody foretells where it goes: that the
    fit does not know says nothing of what else is left."""
    residual = last.residuals[name]
    if not any(added.walks and name in added.columns for added in last.world.added):
        return np.zeros(len(residual), bool)
    return np.asarray(split.held[split.blocks_of(last.world.times_of(name)[: len(residual)])])


def _band(residual: Array, step_s: float) -> tuple[float, float]:
    """The band that holds the middle nine tenths of a residual's power, Hz."""
    power = np.abs(np.fft.rfft(residual)) ** 2
    hz = np.fft.rfftfreq(len(residual), step_s)
    total = np.cumsum(power[1:])
    if not len(total) or total[-1] <= 0.0:
        return 0.0, 0.0
    low, high = np.searchsorted(total, [0.05 * total[-1], 0.95 * total[-1]])
    return float(hz[1 + low]), float(hz[1 + min(high, len(total) - 1)])


def times_what_matters(last: Fit, name: str, split: Split) -> float:
    """How many times what matters (contract.md) a fit leaves in a channel."""
    rms, noise = _beyond_noise(last, name, split)
    return rms / max(MATTERS_OF_NOISE * noise, least_that_matters(last, name))
