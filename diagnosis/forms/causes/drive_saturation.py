"""A drive that cannot go as fast as declared."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    top = context.top_command_rad_s
    return [
        Trial({}, ({"drive.max_velocity_rad_s": share * top},), one_sided=True)
        for share in (0.99, 0.97, 0.95, 0.92, 0.89, 0.85, 0.8, 0.75, 0.7, 0.63, 0.56, 0.5, 0.42, 0.35, 0.25)
    ]


CAUSE = Cause(
    id="drive_saturation",
    needs=driven,
    trials=_trials,
    free=free_of("drive.max_velocity_rad_s"),
    parameters_of=lambda fit: plain(fit, max_velocity_rad_s="drive.max_velocity_rad_s"),
    settle={"drive.max_velocity_rad_s": 0.01},
)
