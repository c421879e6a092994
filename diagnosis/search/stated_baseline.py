"""The baseline with the modes that the model states, where the fitted one has left them far behind.

What acts throughout may bend a baseline as far as it goes: an arm that dry friction stops within a swing is fitted with
another frequency and forty times the damping, and from there no direction leads to the friction. Beside the modes as
stated the cause is plain, whatever else these leave.
"""

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import without_impacts_while_moving
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data

_FAR = 1.15  # times a mode's frequency, or its inverse: no measured model is as wrong
_FAR_DAMPING, _DAMPED = 5.0, 0.05  # times its damping, and that it has at least: an arm that hardly rings
_STEPS = 6  # of a fit of all but the modes


def stated_baseline(baseline: Fit, split: Split) -> Fit | None:
    """The recording as the stated modes foretell it, all else fitted; None where the baseline has them too."""
    if baseline.world.measured.pair or not _has_left(baseline):
        return None
    fewer = without_impacts_while_moving(baseline)
    space = fewer.space
    stated = {name: space[name].start for name in space.names(("modes.",))}
    start = space.with_values(carried_over(baseline, fewer), stated)
    names = [name for name in fewer.baseline_names() if name not in stated]
    return fit(make_data(fewer, split), start, names, iterations=_STEPS, colour=baseline.colour)


def _has_left(baseline: Fit) -> bool:
    """Whether a fit has left what the model states of its first mode far behind."""
    space = baseline.world.space
    ratio = baseline.value("modes.0.frequency_hz") / space["modes.0.frequency_hz"].start
    damping, stated = baseline.value("modes.0.damping_ratio"), space["modes.0.damping_ratio"].start
    return max(ratio, 1.0 / ratio) > _FAR or damping > max(_FAR_DAMPING * stated, _DAMPED)
