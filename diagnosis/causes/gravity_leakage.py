"""Gravity in a tilting accelerometer."""

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("accelerometer.gravity_m_s2_per_rad")
    return [Trial({}, ({"accelerometer.gravity_m_s2_per_rad": now + size},)) for size in (0.1,)]


CAUSE = Cause(
    id="gravity_leakage",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.gravity_m_s2_per_rad"),
    parameters_of=lambda fit: plain(fit, gain_m_s2_per_rad="accelerometer.gravity_m_s2_per_rad"),
)
