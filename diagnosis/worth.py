"""Whether a refitted cause is large enough to have a name.

With fifty thousand samples a lag of six microseconds, or a frequency that changed by a hundred-thousandth, gains tens
of nats; but at such sizes anything that moves the arm by as little looks the same, and no drive, sensor or clock is
what its model says to so many digits.
"""

from math import isnan

import numpy as np

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.common.causes import Parameter
from stillarm.diagnosis.candidate import Candidate

_SHARE = 0.01  # of the least that is typical; of a declared bandwidth
_RELATIVE = ("bandwidth_hz",)
_LIMITS = ("max_velocity_rad_s", "range_m_s2")  # where values pile up, whatever the limit
# half a usual image: what is typical of a lens is so there; where it is wider, less shows as much
_WIDE_PX = 500.0


def worth_a_name(one: Candidate) -> bool:
    """Whether the size of a cause is at least a hundredth of the least that its catalogue has for typical; of a lens,
    by what it does at the image's edge."""
    size = _size_of(one.cause)
    pair = one.fit.world.measured.pair  # in units of its own
    if one.law is not None or pair or size is None or size.name not in one.values:
        return True
    value = one.values[size.name][0]
    neutral, least = size.neutral, _SHARE * size.typical[0]
    if isnan(neutral):
        neutral = one.fit.world.space[one.free[0]].start
    if size.name in _RELATIVE:
        least = _SHARE * abs(neutral)
    if size.unit == "1/px^2":
        seen = one.fit.world.measured.frames.displacement_px
        widest = float(np.nanmax(np.abs(seen), initial=_WIDE_PX))
        least *= (_WIDE_PX / widest) ** 2
    return abs(value - neutral) >= least


def _size_of(cause: str) -> Parameter | None:
    """The number that says how large a cause is: its last, phases and what may be left out aside."""
    numbers = [one for one in CATALOGUE[cause].parameters if one.kind == "number" and one.default is None]
    size = numbers[-1]
    return None if size.name in _LIMITS or size.typical[0] <= 0.0 else size
