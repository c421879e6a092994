"""A bias of the accelerometer that drifts."""

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("accelerometer.rate_m_s3")
    return [Trial({}, ({"accelerometer.rate_m_s3": now + size},)) for size in (0.001,)]


CAUSE = Cause(
    id="accelerometer_bias_drift",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.rate_m_s3"),
    parameters_of=lambda fit: plain(fit, rate_m_s3="accelerometer.rate_m_s3"),
)
