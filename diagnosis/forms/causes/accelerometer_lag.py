"""An accelerometer that lags."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, free_of, has, plain
from stillarm.diagnosis.physics.quantities import OF_LAST_JUMP


def _trials(context: Context) -> list[Trial]:
    now = context.value("accelerometer.delay_s")
    return [Trial({}, ({"accelerometer.delay_s": now + size},)) for size in (0.0005, 0.005, 0.02)]


CAUSE = Cause(
    id="accelerometer_lag",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.delay_s", OF_LAST_JUMP),
    parameters_of=lambda fit: plain(fit, delay_s="accelerometer.delay_s"),
)
