"""Friction in the joint."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    top = context.top_command_rad_s
    known = context.declared("drive.velocity_loss_rad_s")
    return [
        Trial({}, ({"drive.velocity_loss_rad_s": known + share * top},), one_sided=known == 0.0)
        for share in (0.002, 0.01, 0.04, 0.1, 0.2)
    ]


CAUSE = Cause(
    id="joint_friction",
    needs=driven,
    trials=_trials,
    free=free_of("drive.velocity_loss_rad_s"),
    parameters_of=lambda fit: plain(fit, velocity_loss_rad_s="drive.velocity_loss_rad_s"),
)
