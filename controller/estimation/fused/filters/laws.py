"""Five laws by which a frame may be dated, each at two levels of disturbance: ten filters, and their places.

Implements Eq. 18 of docs/fused.md.
"""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class Law(IntEnum):
    """How the instant of a frame is said to follow."""

    CLOCK = 0  # t0 + k T, k from the frame counter
    STAMPS = 1  # the camera's own stamps
    STEADY = 2  # arrival minus a constant delay
    DRIFT = 3  # arrival minus a wandering delay
    JITTER = 4  # arrival minus a delay of its own for each frame


LAWS = len(Law)
LEVELS = 2  # of unforeseen disturbance: quiet, disturbed
FILTERS = LAWS * LEVELS  # filter f follows law f % LAWS at level f // LAWS
LAW_OF = np.arange(FILTERS) % LAWS
ALL, QUIET, DISTURBED = slice(None), slice(0, LAWS), slice(LAWS, None)
CLOCKED = (LAW_OF == Law.CLOCK) | (LAW_OF == Law.STAMPS)  # filters whose frames a clock dates
