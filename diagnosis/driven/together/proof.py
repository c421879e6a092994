"""Identification on some recordings, proof on another: which of them the extended model makes worse.

For each recording the common numbers are fitted once more to the others, from where they are, with the causes and
without. What a recording has for itself stays as it was; each of its blocks gives its own initial state.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.recording.own import recording_of

_STEPS = 6  # of a fit from the numbers that all recordings gave: it is near its end
WORSE_NATS = 3.0  # lost: 20 to 1


@dataclass(frozen=True)
class Proof:
    """Of one recording, foretold by the others. rms: by output without and with the causes; nats: gained by them."""

    recording: int
    rms: dict[str, tuple[float, float]]
    nats: float

    @property
    def worse(self) -> bool:
        """Whether the extended model foretells the recording less well than the plain one."""
        return self.nats < -WORSE_NATS


def proofs(
    start: DrivenFit, final: DrivenFit, left_s: Callable[[], float] = lambda: inf
) -> tuple[Proof | None, ...]:
    """Of each recording; None where the time ran out."""
    found: list[Proof | None] = []
    for k in range(final.box.driven.recordings):
        if left_s() < 0.0:
            found.append(None)
            continue
        plain, extended = (_without(one, k).part(k) for one in (start, final))
        rms = {
            name: (_rms(plain.residuals[name]), _rms(extended.residuals[name])) for name in extended.residuals
        }
        found.append(Proof(k, rms, float((extended.whole - plain.whole).sum())))
    return tuple(found)


def _without(fitted: DrivenFit, recording: int) -> DrivenFit:
    """The fit with the common numbers as the other recordings give them."""
    box = fitted.box
    held = box.split.held | (box.recording == recording)
    box = replace(box, split=replace(box.split, held=held))
    free = tuple(one for one in fitted.free if recording_of(one) != recording)
    return fit(box, fitted.numbers, free, fitted.states, steps=_STEPS)


def _rms(residual: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(residual**2)))
