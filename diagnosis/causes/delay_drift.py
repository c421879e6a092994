"""A capture delay that drifts."""

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("timing.delay_rate")
    return [Trial({}, ({"timing.delay_rate": now + size},)) for size in (0.0001,)]


CAUSE = Cause(
    id="delay_drift",
    needs=has("displacement", "arrival"),
    trials=_trials,
    free=free_of("timing.delay_rate"),
    parameters_of=lambda fit: plain(fit, rate_s_per_s="timing.delay_rate"),
)
