"""A form's fit from one of its starts: how far along its direction that lies, and near enough that it is sound."""

from stillarm.diagnosis.driven.fitting.fitting import SEARCH_STEPS, DrivenFit, fit, runs_away
from stillarm.diagnosis.driven.mechanisms.mechanisms import Form, box_of
from stillarm.diagnosis.driven.recording.own import base_of

LEAST_PART, MOST_PART = 0.003, 3.0
"""Of the way to a start: further the first order does not hold."""

# no small part of these is a small effect of the same kind
_NO_DIRECTION = ("limit", "gap", "onset", "dead_cut")
_ONE_SIDED = ("coulomb", "stribeck", "dead_zone", "lag", "arm_coulomb")
_SHAPES = ("log_stribeck_velocity", "ripple_cycles", "gravity_cycles", "late", "on_motor", "share", "bounce")
_MOST_HALVINGS = 6  # of the way to a start that runs away: a 32nd is as good as no way


def fitted_from(
    form: Form, start: dict[str, float], current: DrivenFit, least: float = 0.0
) -> DrivenFit | None:
    """A form's fit from a start beside what there is. A start whose simulation runs away is moved back towards what
    there is; None where even that runs away. least: nats of a step, see `fit`."""
    from_here = box_of(form, current)
    free = tuple(dict.fromkeys((*current.free, *(one for one in form.numbers if base_of(one) != "late"))))
    kept = {name: value for name, value in start.items() if name in free or name not in current.numbers}
    for _ in range(_MOST_HALVINGS):
        numbers = {**current.numbers, **kept}
        if not runs_away(from_here.box, numbers, from_here.states):
            return fit(from_here.box, numbers, free, from_here.states, SEARCH_STEPS, least)
        kept = _moved(current, kept, 0.5)
    return None


def moved_along(current: DrivenFit, start: dict[str, float], along: float) -> dict[str, float]:
    """A start, as far along its direction as explains most to first order. A start far beyond that leaves the valley in
    which the fit is; numbers that give an effect its shape, not its size, stay."""
    if any(base_of(name) in _NO_DIRECTION for name in start):
        return start
    part = min(max(abs(along), LEAST_PART), MOST_PART)
    if along < 0.0:  # the other way, where that can be: no friction drives a joint on
        part = LEAST_PART if any(base_of(name).startswith(_ONE_SIDED) for name in start) else -part
    return _moved(current, start, part)


def _moved(current: DrivenFit, start: dict[str, float], part: float) -> dict[str, float]:
    """A part of the way from what there is to a start."""
    held = {**current.box.declared, **current.numbers}
    moved = {}
    for name, value in start.items():
        neutral = 1.0 if name.startswith("scale") else 0.0
        before = held.get(name, held.get(base_of(name), neutral))
        shape = base_of(name).startswith(_SHAPES)
        moved[name] = value if shape else before + part * (value - before)
    return moved
