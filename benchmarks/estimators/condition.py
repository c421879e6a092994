"""A departure from what the methods are told, as the third table's rows are made of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.estimators.generator import Change, Data, Excitation
from benchmarks.estimators.regimes import DURATION_S, SETTLING_S, Arm

_AS_TOLD = Arm()
Span = tuple[float, float]


@dataclass(frozen=True)
class Condition:
    """What differs. from_s: scored from then on; duration_s: of the trial.

    excite: what keeps the arm moving, None: blows. change_data: what befalls the measurements, given the trial and a
    source of chance. during: from when to when the figures *_during are taken, given the trial; none where it is None.
    """

    arm: Arm = _AS_TOLD
    change: Change | None = None
    scale_factor: float = 1.0
    duration_s: float = DURATION_S
    from_s: float = SETTLING_S
    change_data: Callable[[Data, np.random.Generator], Data] = lambda data, random: data
    excite: Excitation | None = None
    during: Callable[[Data], list[Span]] | None = None
