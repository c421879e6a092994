"""The log score of a fit's residual, by block and band of frequency, each with a level of its own."""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.signals import Output
from stillarm.diagnosis.fitting.band_score import Spectra, nats_by_band, spectra

Array = NDArray[np.float64]


def spectra_of(part: GreyBox, output: Output, residual: Array) -> Spectra:
    """Of an output's residual in one recording."""
    least = max(0.29 * output.step, 1e-6 * float(np.nanstd(output.values)))
    by_bands = spectra(residual, part.driven.step_s, part.block, len(part.split.held), least)
    # a block's own initial state takes its residual's mean away: how exactly says nothing of the model
    by_bands.count[:, 0], by_bands.power[:, 0] = 0.0, 0.0
    return by_bands


def _scored(part: GreyBox, residuals: dict[str, Array], rows: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Nats of a recording's blocks and bands, by levels of those that trained, and of all."""
    count = len(part.split.held)
    held, whole = [], []
    for one in part.driven.outputs:
        by_bands = spectra_of(part, one, residuals[one.name][rows])
        whole.append(nats_by_band(by_bands, np.ones(count, bool)))
        trains = ~part.split.held
        held.append(nats_by_band(by_bands, trains) if trains.any() else np.zeros_like(whole[-1]))
    return np.asarray(sum(held)), np.asarray(sum(whole))


def scored(box: GreyBox, residuals: dict[str, Array]) -> tuple[Array, Array]:
    """Nats of blocks and bands, by levels of those that trained, and of all; each recording has noise of its own."""
    each = [
        _scored(box.parts[k], residuals, (box.recording == k)[box.block])
        for k in range(box.driven.recordings)
    ]
    held, whole = (np.concatenate([one[i] for one in each]) for i in (0, 1))
    return held, whole
