"""A longer dead time of the drive."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    now = context.value("drive.dead_time_s")
    return [Trial({}, ({"drive.dead_time_s": now + more},)) for more in (0.0005, 0.004, 0.015, 0.04)]


CAUSE = Cause(
    id="drive_dead_time",
    needs=driven,
    trials=_trials,
    free=free_of("drive.dead_time_s"),
    parameters_of=lambda fit: plain(fit, dead_time_s="drive.dead_time_s"),
)
