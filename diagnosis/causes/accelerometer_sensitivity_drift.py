"""A sensitivity of the accelerometer that drifts."""

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("accelerometer.rate_per_s")
    return [Trial({}, ({"accelerometer.rate_per_s": now + size},)) for size in (0.001,)]


CAUSE = Cause(
    id="accelerometer_sensitivity_drift",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.rate_per_s"),
    parameters_of=lambda fit: plain(fit, rate_per_s="accelerometer.rate_per_s"),
)
