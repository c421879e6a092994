"""A camera clock that runs fast or slow."""

from stillarm.diagnosis.inference.cause import Cause, Context, Trial, Values, free_of, has, plain
from stillarm.diagnosis.inference.fitted import Fit
from stillarm.diagnosis.physics.quantities import QUARTZ, SKEW


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
