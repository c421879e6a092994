"""A dead band of the drive."""

from diagnosis.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    top = context.top_command_rad_s
    return [
        Trial({}, ({"drive.deadband_rad_s": share * top},), one_sided=True)
        for share in (0.005, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.22, 0.3)
    ]


CAUSE = Cause(
    id="drive_deadband",
    needs=driven,
    trials=_trials,
    free=free_of("drive.deadband_rad_s"),
    parameters_of=lambda fit: plain(fit, deadband_rad_s="drive.deadband_rad_s"),
    settle={"drive.deadband_rad_s": 0.002},
)
