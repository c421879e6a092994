"""A form that holds another one wins its odds against that in the final model, or gives way to it.

Dry friction that is larger at rest is dry friction with two numbers more. While other causes are still missing, those
numbers make up for them; what is then left of their gain shows only once all is in. A search may take both, one after
the other. They are one cause then: neither is worth anything beside the other, which keeps its numbers in the model.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf

from stillarm.diagnosis.driven.fitting.fitting import NEAR_STEPS, DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.mechanisms import FORMS, STRUCTURE, Form
from stillarm.diagnosis.driven.search.judging import CONVINCES, judged
from stillarm.diagnosis.driven.search.search import Round, Searched, holds_in


def plainest(found: Searched, left_s: Callable[[], float] = lambda: inf) -> Searched:
    """What the search found, with the plainest form of each cause that does as well."""
    rounds, final = list(found.rounds), found.final
    for place, one in enumerate(rounds):
        form = one.taken.form
        if form.cause == STRUCTURE:
            continue
        tried = [
            *(each for each in FORMS if each.fits(final) and not each.hidden),
            *(each.form for each in one.tried),
        ]
        plainer = {each.numbers: each for each in tried if holds_in(each, form) and each.cause != STRUCTURE}
        for plain in sorted(plainer.values(), key=lambda each: each.price):
            if left_s() < 0.0:
                break
            without = _reduced(final, form, plain, [each.taken.form for each in rounds])
            if judged(_more(form, plain), final, without).merit < CONVINCES:
                rounds[place] = Round(one.before, (replace(one.taken, form=plain), *one.tried[1:]))
                final = without
                break
    return replace(found, rounds=tuple(_each_once(rounds)), final=final)


def _each_once(rounds: list[Round]) -> list[Round]:
    """Each cause once: without the rounds whose form is that of an earlier round, or is held in another one's."""
    kept: list[Round] = []
    for place, one in enumerate(rounds):
        form = one.taken.form
        again = any(other.taken.form.numbers == form.numbers for other in kept)
        fuller = any(holds_in(form, other.taken.form) for other in (*kept, *rounds[place + 1 :]))
        if form.cause == STRUCTURE or not (again or fuller):
            kept.append(one)
    return kept


def _reduced(final: DrivenFit, form: Form, plain: Form, taken: list[Form]) -> DrivenFit:
    """The final model refitted without the numbers that a form has beyond the plainer one."""
    others = {name for one in taken if one is not form for name in one.numbers}
    gone = set(form.numbers) - set(plain.numbers) - others
    numbers = {name: value for name, value in final.numbers.items() if name not in gone}
    free = tuple(one for one in final.free if one not in gone)
    return fit(final.box, numbers, free, final.states, steps=NEAR_STEPS)


def _more(form: Form, plain: Form) -> Form:
    """What a form adds to the plainer one."""
    return replace(form, numbers=tuple(one for one in form.numbers if one not in plain.numbers))
