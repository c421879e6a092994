"""Where the fit of a form begins."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Begun:
    """A form with its world and where its fit begins."""

    form: Form
    world: World
    start: Array
    asked: bool = False
