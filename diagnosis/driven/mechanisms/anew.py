"""A torque that holds on, begun anew: one beside which the start's fit has settled on another joint and another arm.

A constant torque moves the mean of the input, gravity the joint's slow answer. Where it is large, a linear fit without
it bends gain, damping and modes until they make up for it, and no small step leads back from there. Here the torque
is fitted beside the numbers from which the start's fit began.
"""

from collections.abc import Callable, Iterator

from stillarm.diagnosis.driven.fitting.fitting import SEARCH_STEPS, DrivenFit, fit
from stillarm.diagnosis.driven.fitting.freedom import free_of


def anew_with(*names: str) -> Callable[[DrivenFit], Iterator[dict[str, float]]]:
    """Starts of a form with these numbers, which may have either sign."""

    def starts(fitted: DrivenFit) -> Iterator[dict[str, float]]:
        box, begun = fitted.box, fitted.box.begun
        own = set(free_of(box)) | set(begun)
        if not begun or box.play or not set(fitted.free) <= own:  # causes or modes have been added since
            return
        numbers = {**fitted.numbers, **begun, **dict.fromkeys(names, 0.0)}
        yield fit(box, numbers, (*fitted.free, *names), None, steps=SEARCH_STEPS).numbers

    return starts
