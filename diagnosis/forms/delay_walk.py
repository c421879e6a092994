"""A capture delay that strays further than the model states, along no straight line.

The delay's usual law is a wander in white noise, of which both together have the stated deviation. How likely the
arrivals are by that is held against the same law with a wander of any size and length. The log score of evidence.py
cannot tell: it is of what the usual law makes of the arrivals, and that follows a slow walk nearly to the end. A course
of steps then stands for the walk in the fit.
"""

from math import inf, log

from stillarm.diagnosis.data.noise import WanderLaw, wander_law
from stillarm.diagnosis.fitting.evidence import PRICE_NATS
from stillarm.diagnosis.fitting.fit import WANDER_S
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.forms.courses import Walk, of_walk, walk_that_lasts
from stillarm.diagnosis.physics.computing import Lately

_NUMBERS = 3  # of the law: how far, for how long, and the noise
_LASTS_S = 2.0  # that a walk is remembered at least: what is shorter is a burst
_LONGEST = 4.0  # correlation time, in recordings: a walk that lasts longer looks no different
_LAWS: Lately[tuple[bytes, float, float], WanderLaw | None] = Lately(16)
"""By what a fit leaves of the arrivals, how long a wander may last, frames, and how far it may stray, s."""


def delay_walk(last: Fit) -> Walk | None:
    """The walk of the delay that a fit leaves in the arrivals; None where there is none, or none is too far."""
    usual, free = _law_of(last, usual=True), _law_of(last, usual=False)
    if usual is None or free is None or free.colour.stay == 0.0:
        return None
    lasts_s = -last.world.step_s("arrival") / log(free.colour.stay)
    gain = free.nats - usual.nats - PRICE_NATS * _NUMBERS
    if lasts_s < _LASTS_S or gain <= 0.0:
        return None
    return walk_that_lasts(lasts_s, free.std * free.colour.wandered, gain)


def is_foretold(last: Fit, other: Fit) -> bool:
    """Whether another fit leaves arrivals that are by the usual law no less likely than what this one leaves is with
    its walk."""
    walk, rest = _law_of(last, usual=False), _law_of(other, usual=True)
    return walk is not None and rest is not None and rest.nats >= walk.nats


def _law_of(last: Fit, usual: bool) -> WanderLaw | None:
    """The likeliest law of what a fit leaves of the arrivals; None where they were not measured, or the model does not
    state how far they scatter."""
    arrivals, stated_s = last.channel("arrival"), last.world.model.timing.capture_delay_std_s
    if arrivals is None or stated_s <= 0.0:
        return None
    off = arrivals.off
    longest, most_s = (
        (WANDER_S / last.world.step_s("arrival"), stated_s) if usual else (_LONGEST * len(off), inf)
    )
    return _LAWS.of((off.tobytes(), longest, most_s), lambda: wander_law(off, longest, most_s))


FORM: Form = of_walk("delay_drift", "rate_s_per_s", "arrival", "strayed delay", delay_walk)
