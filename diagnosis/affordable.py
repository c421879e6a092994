"""How much of a long recording a budget of time suffices for."""

from itertools import pairwise

from stillarm.diagnosis.budget import Budget
from stillarm.diagnosis.world import World

RUNS = (
    700  # simulations in a baseline and a round of the search, the median of the table in docs/diagnosis.md
)
_TIMED = 3  # simulations, of which the quickest counts: another process may take the processor meanwhile
MIN_S = 10.0  # less than that shows hardly any vibration; a smaller budget stops between stages


def affordable(world: World, budget: Budget) -> float:
    """Seconds of the recording, from its start on, that can be diagnosed in what is left of the budget; all of them
    where there is no limit. Measured by simulations of the recording."""
    left_s, duration_s = budget.left_s, world.measured.duration_s
    if left_s is None or duration_s <= MIN_S:
        return duration_s
    vector = world.space.vector()
    world.predict(vector)  # compiles, where nothing has yet
    times_s = [budget.clock()]
    for _ in range(_TIMED):
        world.predict(vector)
        times_s.append(budget.clock())
    needed_s = RUNS * min(end - begin for begin, end in pairwise(times_s))
    stages_s = max(budget.stages_s - budget.used_s, 0.0)
    return min(duration_s, max(MIN_S, duration_s * stages_s / max(needed_s, 1e-9)))
