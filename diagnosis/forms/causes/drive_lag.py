"""A slower drive."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("drive.bandwidth_hz")
    return [Trial({}, ({"drive.bandwidth_hz": now * ratio},)) for ratio in (0.97, 0.7, 0.4, 0.2, 1.6)]


CAUSE = Cause(
    id="drive_lag",
    needs=driven,
    trials=_trials,
    free=free_of("drive.bandwidth_hz"),
    parameters_of=lambda fit: plain(fit, bandwidth_hz="drive.bandwidth_hz"),
)
