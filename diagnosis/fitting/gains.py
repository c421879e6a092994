"""What a fit of a further form frees, and what it gains."""

from collections.abc import Sequence

import numpy as np

from stillarm.diagnosis.fitting.fit import SETTLED_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.quantities import COASTING
from stillarm.diagnosis.physics.world import World

_SETTLED = 1e-3  # of what a form has gained: a step or a trial that gains less changes no comparison


def free_names(last: Fit, world: World, own: Sequence[str]) -> tuple[str, ...]:
    """What a fit of a further cause frees: the baseline, what earlier findings freed, and its own. Not a play behind
    which the link coasts, once that is found: every touch decides where the next one is, so that its derivatives hold
    for nearby alone, and no step that follows them gains anything of what else is fitted."""
    kept = (name for name in last.free if name in world.space.place and name not in COASTING)
    return world.with_baseline((*kept, *own))


def gain_of(fitted: Fit, last: Fit) -> float:
    gained = fitted.held_out_score - last.held_out_score
    return fitted.train_log_likelihood - last.train_log_likelihood + float(np.sum(gained))


def settled_nats(fitted: Fit, last: Fit) -> float:
    return max(SETTLED_NATS, _SETTLED * gain_of(fitted, last))
