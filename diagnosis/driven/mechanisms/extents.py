"""Forms of causes that hold in all recordings of a rig, and in one of them alone.

What one recording has for itself may also be a number that every rig has: another inertia, as of a load that was put
on, shows against the other recordings, where no model says what it should be.
"""

from dataclasses import replace

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.fitting.freedom import STATED, has_joint
from stillarm.diagnosis.driven.mechanisms.mechanisms import STRUCTURE, Form, Starts, forms_for
from stillarm.diagnosis.driven.recording.own import named_in

_ONSET = "onset"  # s from a recording's start: no time that recordings have in common
_MORE = 1.2  # times what the others have: where the search for another value begins


def forms_of_all(fitted: DrivenFit) -> list[Form]:
    """Every form, in all recordings and in each alone."""
    driven = fitted.box.driven
    found = [one for one in forms_for(fitted) if _ONSET not in one.numbers]
    # of two recordings the second differs from the first: that is the same as the other way round
    others = range(1 if driven.recordings == 2 else 0, driven.recordings)
    for k in range(driven.recordings):
        seen = fitted.part(k)
        here = [one for one in forms_for(seen) if one.cause != STRUCTURE and not one.play]
        if k in others:
            here += _against_the_others(seen)
        restricted = [_in_one(one, k) for one in here]
        found += [one for one in restricted if not set(one.numbers) <= set(fitted.free)]
    return found


def _against_the_others(seen: DrivenFit) -> list[Form]:
    """What every rig has, at another value than the other recordings show."""
    if not has_joint(seen.box.driven) or STATED in seen.numbers:  # a model says what it should be
        return []
    against = "against the other recordings"
    forms = [Form("inertia_change", against, ("inertia_excess",), _more_or_less)]
    forms.append(Form("joint_viscous_friction", against, ("damping",), _more_damping))
    if seen.box.modes:
        load = ("log_w_1", "carries_1", "zeta_1")
        forms.append(Form("inertia_change", f"a payload at the tip, {against}", load, _payload))
    return forms


def _in_one(form: Form, recording: int) -> Form:
    """The form with numbers of that recording alone."""

    def starts(fitted: DrivenFit) -> Starts:
        for start in form.starts(fitted.part(recording)):
            yield {named_in(name, recording): value for name, value in start.items() if name in form.numbers}

    numbers = tuple(named_in(one, recording) for one in form.numbers)
    return replace(form, numbers=numbers, starts=starts)


def _more_or_less(fitted: DrivenFit) -> Starts:
    for share in (0.2, -0.2):
        yield {"inertia_excess": share}


def _more_damping(fitted: DrivenFit) -> Starts:
    yield {"damping": _MORE * fitted.numbers["damping"] + 1e-3}


def _payload(fitted: DrivenFit) -> Starts:
    """A load lowers the clamped arm's frequency, and is carried."""
    numbers = fitted.numbers
    yield {
        "log_w_1": numbers["log_w_1"] - 0.1,
        "carries_1": _MORE * numbers["carries_1"] + 1e-3,
        "zeta_1": numbers["zeta_1"],
    }
