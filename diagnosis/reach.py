"""How surely a threshold is known: a play, a dead band, a limit. The likelihood has no slope between the values that
the data tell apart, and none of its derivatives says how far apart those are: so it is walked along to either side.
"""

from collections.abc import Callable

from stillarm.diagnosis.cause import Cause
from stillarm.diagnosis.fit import Fit, Split, fit, make_data

_DROP_NATS = 0.5  # of a Gaussian likelihood one standard deviation off
_FIRST, _GROWTH = 1e-4, 1.6  # of the value
_HALVINGS = 5


def reach_of(final: Fit, cause: Cause, split: Split) -> dict[str, float]:
    """How far from its fitted value each threshold of a cause may lie, in the quantity's own unit: to the side on which
    the log-likelihood of all data takes longer to fall by half a nat, all else as fitted."""
    thresholds = [name for name in cause.settle if "onset" not in name]
    if not thresholds:
        return {}
    data = make_data(final.world, split)

    def nats(name: str, off: float) -> float:
        vector = final.world.space.with_values(final.vector, {name: final.value(name) + off})
        at = fit(data, vector, (), iterations=0, colour=final.colour)
        return at.train_log_likelihood + float(at.held_out_score.sum())

    def reach(name: str) -> float:
        least, whole = nats(name, 0.0) - _DROP_NATS, abs(final.value(name))
        return max(_side(lambda off: nats(name, off) > least, side) for side in (whole, -whole))

    return {name: reach(name) for name in thresholds}


def _side(likely: Callable[[float], bool], whole: float) -> float:
    """How far off, up to the whole, something is likely still."""
    inner, outer = 0.0, _FIRST
    while likely(outer * whole):
        if outer == 1.0:
            return abs(whole)
        inner, outer = outer, min(_GROWTH * outer, 1.0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (inner + outer)
        inner, outer = (middle, outer) if likely(middle * whole) else (inner, middle)
    return abs(outer * whole)
