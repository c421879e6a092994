"""Where the fit of a form begins: on top of which fit, in which world, and from what values."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.evidence import Score, score
from stillarm.diagnosis.fitting.fit import Slopes, slopes_of
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ground:
    """The fit on top of which forms are compared. score: its own; slopes: its derivatives, which stay while a form is
    fitted beside it (chord method)."""

    last: Fit
    split: Split
    score: Score
    slopes: Slopes


def ground_of(last: Fit, split: Split) -> Ground:
    """A fit as the ground of a comparison."""
    return Ground(last, split, score(last, split), slopes_of(last))


@dataclass(frozen=True)
class Begun:
    """A form with its world and where its fit begins. asked: by the data, whatever a score test says. promised: what
    that says, over the most that it says of any form."""

    form: Form
    world: World
    start: Array
    asked: bool = False
    promised: float = 0.0


Pair = tuple[Begun, Fit]
"""A form, and its fit."""
