"""A form that was found on top of another fit, carried over to this one: a hint, and the second best of a round beside
what that round took.

Where one of the second best explains all that is left, no form has to be compared anew. Each form that explains the
same promised as much of it in the round before, and was fitted there.
"""

from collections.abc import Sequence

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.fitted import Fit, carried_over
from stillarm.diagnosis.forms.cause import Form
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.search.begun import Begun, Ground, ground_of
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.refits import TO_REST, candidate_of, polished, refitted

_STEPS = 8  # twice those of a quick fit: what is taken is fitted until no step gains anything
_SECOND_BEST = 4  # causes: the best two and two rivals, on as many processors as there are


def second_best(
    last: Fit, others: Sequence[Candidate], tried: Sequence[Form], split: Split
) -> list[Candidate]:
    """The best candidates of a round, but for the one that it took, each refitted beside that one. last: the fit with
    what was taken; tried: forms that may be named now."""
    if not others:
        return []
    ground = ground_of(last, split)

    def carried(one: Candidate) -> Candidate | None:
        try:
            return hinted(ground, one, tried, _STEPS)
        except OutOfTime:
            return None

    known = [*others, last, last.world, last.predicted.motion]
    return [one for one in shared_out(carried, others[:_SECOND_BEST], known) if one is not None]


def hinted(ground: Ground, hint: Candidate, tried: Sequence[Form], steps: int = TO_REST) -> Candidate | None:
    """A form that was found beside another baseline, fitted from what it was there, its onset and its thresholds with
    it, in so many steps with all derivatives at most; None where that is not possible here."""
    last, there = ground.last, hint.fit.world
    form = next((one for one in tried if (one.id, one.name) == (hint.cause, hint.form)), None)
    if form is None:
        return None
    terms = form.added(last) if form.added is not None else ()
    # what was taken since may have given the arm a mode, or play behind the encoder, that the hint's world lacks
    world = last.world.changed(
        extra_modes=max(last.world.extra_modes, there.extra_modes),
        behind_encoder=last.world.behind_encoder or there.behind_encoder,
        added=(*last.world.added, *terms),
    )
    own = {*hint.free, *form.cause.settle, *([hint.begins] if hint.begins is not None else [])}
    if not own <= set(world.space.place):
        return None
    values = {name: hint.fit.value(name) for name in own}
    begun = Begun(form, world, world.space.with_values(carried_over(last, world), values))
    fitted = refitted(ground, begun)
    return None if fitted is None else candidate_of(ground, polished(ground, (begun, fitted), steps))
