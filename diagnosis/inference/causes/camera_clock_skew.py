"""A camera clock that runs fast or slow."""

from stillarm.diagnosis.inference.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("timing.skew_ppm")
    return [Trial({}, ({"timing.skew_ppm": now + size},)) for size in (5.0,)]


CAUSE = Cause(
    id="camera_clock_skew",
    needs=lambda world: has("displacement", "arrival")(world) and world.frame_clock.counted,
    trials=_trials,
    free=free_of("timing.skew_ppm"),
    parameters_of=lambda fit: plain(fit, skew_ppm="timing.skew_ppm"),
)
