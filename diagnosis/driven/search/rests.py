"""What a fit leaves of a channel beside its noise, and whether that matters."""

from dataclasses import dataclass

import numpy as np

from stillarm.diagnosis.data.noise import MATTERS_OF_MOTION, MATTERS_OF_NOISE
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit

_QUIET = 0.25  # of the blocks
_FEWEST_BLOCKS = 6  # from more of them on the loudest is left out
_MOST_COLOUR = 3.0  # times the white noise, of the quietest blocks


@dataclass(frozen=True)
class Rest:
    """What a channel's residual holds beyond its noise, in its unit."""

    channel: str
    rms: float
    noise: float
    band_hz: tuple[float, float]
    matters: bool


def rest_of(fitted: DrivenFit, name: str) -> Rest:
    """What is left in a channel beside its noise: the white part, or what the quietest quarter of the blocks has."""
    output = next(one for one in fitted.box.driven.outputs if one.name == name)
    residual, h = fitted.residuals[name], fitted.box.driven.step_s
    known = residual[np.isfinite(residual)]
    white = float(np.sqrt(np.mean(np.diff(known, 2) ** 2) / 6.0))
    blocks = [residual[fitted.box.block == b] for b in range(len(fitted.states))]
    levels = [float(np.sqrt(np.nanmean(one**2))) for one in blocks if np.isfinite(one).sum() > 12]
    quiet = float(np.quantile(levels, _QUIET))
    noise = max(white, 0.29 * output.step, min(quiet, _MOST_COLOUR * white))
    usual_blocks = (
        np.sort(levels)[:-1] if len(levels) > _FEWEST_BLOCKS else np.array(levels)
    )  # one may be odd
    rms = float(np.sqrt(max(float(np.mean(usual_blocks**2)) - noise**2, 0.0)))
    spectrum = np.abs(np.fft.rfft(np.nan_to_num(residual))) ** 2
    spectrum[0] = 0.0
    share = np.cumsum(spectrum) / max(spectrum.sum(), 1e-300)
    hz = np.fft.rfftfreq(len(residual), h)
    low, high = (min(int(np.searchsorted(share, one)), len(hz) - 1) for one in (0.1, 0.9))
    band = (float(hz[low]), float(hz[high]))
    usual = float(np.nanstd(output.values))
    matters = rms > MATTERS_OF_NOISE * noise and rms > MATTERS_OF_MOTION * usual
    return Rest(name, rms, noise, band, matters)


def leaves_much(fitted: DrivenFit) -> bool:
    """Whether what any channel has left matters."""
    return any(rest_of(fitted, one.name).matters for one in fitted.box.driven.outputs)
