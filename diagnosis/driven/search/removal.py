"""The final model without one of its forms."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from stillarm.diagnosis.driven.fitting.fitting import NEAR_STEPS, DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.mechanisms import Form


def without_form(
    final: DrivenFit, form: Form, forms: Iterable[Form], start: Mapping[str, float]
) -> DrivenFit:
    """The final model refitted without a form's numbers, unless another form has them too; they are as at the start."""
    others = {name for one in forms if one is not form for name in one.numbers}
    gone = set(form.numbers) - others
    numbers = {name: value for name, value in final.numbers.items() if name not in gone}
    numbers |= {name: start[name] for name in gone if name in start}
    free = tuple(one for one in final.free if one not in gone or one == "delay")
    box, states = final.box, final.states
    if form.play:
        box, states = replace(box, play=False), states[:, :-2]
    return fit(box, numbers, free, states, steps=NEAR_STEPS)
