"""When the accelerometer first shows an impact."""

import numpy as np

from stillarm.diagnosis.fitting.departures import LOUD_OVER_S, loud_beside
from stillarm.diagnosis.fitting.fitted import Fit


def departs_at(last: Fit, cycle: int) -> int | None:
    """The cycle, within a swing of an impact, at which the accelerometer first departs from a model without it: an
    impact that stands too early departs itself from there on. None where it does not, or where it does all along."""
    world = last.world
    acceleration = last.channel("acceleration")
    jump = dict.fromkeys(world.space.names(f"jump.{world.impacts.index(cycle) + 1}."), 0.0)
    without = world.predict(world.space.with_values(last.vector, jump)).channels.get("acceleration")
    if acceleration is None or without is None:
        return None
    off = acceleration.residual + acceleration.predicted - without
    known = np.isfinite(off)
    width = round(LOUD_OVER_S / world.measured.cycle_s)
    loud = np.zeros(len(off), bool)
    loud[known] = loud_beside(off[known], acceleration.residual[known], width)
    reach = round(1.0 / (last.value("modes.0.frequency_hz") * world.measured.cycle_s))
    begins = max(cycle - reach, 0)
    first = np.flatnonzero(loud[begins : cycle + reach])
    if not len(first) or first[0] == 0:
        return None
    return begins + int(first[0]) + width // 2  # the window reaches back by as much
