"""What the model of one recording foretells of another: identified on some samples, proven on others."""

import time

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.diagnosed import DrivenResult, diagnose_read
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven

Array = NDArray[np.float64]


def identified_on(driven: Driven, budget_s: float) -> DrivenResult:
    """The diagnosis of samples in memory, without a model, within budget_s."""
    ended = time.monotonic() + budget_s
    split = irregular(driven.duration_s)
    return diagnose_read(driven, split, None, "", lambda done, what: None, lambda: ended - time.monotonic())


def foretold(final: DrivenFit, other: Driven) -> dict[str, Array]:
    """By output, one free run over all of another recording, (n,) each; its initial state is fitted, nothing else."""
    whole = Split(np.array([0.0, other.duration_s]), np.zeros(1, bool))
    box = GreyBox(other, whole, final.box.modes, final.box.play, final.box.declared)
    return fit(box, final.numbers, ()).run.outputs
