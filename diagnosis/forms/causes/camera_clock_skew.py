"""A camera clock that runs fast or slow."""

from dataclasses import replace

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Cause, Context, Form, Trial, Values, free_of, has, plain
from stillarm.diagnosis.physics.quantities import QUARTZ, SKEW, SKEW_BEGIN

_ONSETS, _TRIED_PPM = 12, 20.0  # over the recording; any size does, as the answer is in proportion


def _trials(context: Context) -> list[Trial]:
    now = context.value(SKEW)
    return [Trial({}, ({SKEW: now + size},)) for size in (5.0,)]


def _values(fit: Fit) -> Values:
    """The whole difference of the two clocks, what sound ones have included."""
    beyond, std = plain(fit, x=SKEW)["x"]
    return {"skew_ppm": (beyond + fit.value(QUARTZ), std)}


CAUSE = Cause(
    id="camera_clock_skew",
    needs=lambda world: has("displacement", "arrival")(world) and world.frame_clock.counted,
    trials=_trials,
    free=free_of(SKEW),
    parameters_of=_values,
)


def _later_trials(context: Context) -> list[Trial]:
    return [Trial({SKEW_BEGIN: begin}, ({SKEW: _TRIED_PPM},)) for begin in context.onsets(_ONSETS)]


FROM_AN_ONSET = Form(replace(CAUSE, trials=_later_trials), "from an onset", begins=SKEW_BEGIN)
"""Of a form throughout the baseline's quartz takes the most, so that the search for onsets would never come to it."""
