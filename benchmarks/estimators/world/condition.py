"""A condition of the third table: a difference between the world and the methods' model."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stillarm.benchmarks.estimators.world.generator import Change, Data, Excitation
from stillarm.benchmarks.estimators.world.regimes import DURATION_S, SETTLING_S, Arm

_AS_TOLD = Arm()
Span = tuple[float, float]


@dataclass(frozen=True)
class Condition:
    """The difference. from_s: start of scoring; duration_s: of the trial.

    excite: excitation of the arm; None: impacts. change_data: change of the measurements, given the trial and a random
    generator. during: intervals of the figures *_during, given the trial; None: no such figures.
    """

    arm: Arm = _AS_TOLD
    change: Change | None = None
    scale_factor: float = 1.0
    duration_s: float = DURATION_S
    from_s: float = SETTLING_S
    change_data: Callable[[Data, np.random.Generator], Data] = lambda data, random: data
    excite: Excitation | None = None
    during: Callable[[Data], list[Span]] | None = None
