"""A dead band of the drive."""

import numpy as np

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    top, known = context.top_command_rad_s, context.declared("drive.deadband_rad_s")
    return [
        Trial({}, ({"drive.deadband_rad_s": share * top},), one_sided=known == 0.0)
        for share in np.geomspace(0.001, 0.4, 28).tolist()
    ]


CAUSE = Cause(
    id="drive_deadband",
    needs=driven,
    trials=_trials,
    free=free_of("drive.deadband_rad_s"),
    parameters_of=lambda fit: plain(fit, deadband_rad_s="drive.deadband_rad_s"),
    settle={"drive.deadband_rad_s": 0.002},
)
