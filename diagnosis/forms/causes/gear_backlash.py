"""Play in the gear."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain


def _trials(context: Context) -> list[Trial]:
    known = context.declared("drive.gap_rad")
    sides = [context.world.behind_encoder]
    if known == 0.0 and {"joint_position", "joint_velocity"} & set(context.world.channels):
        sides.append(True)
    return [
        Trial({}, ({"drive.gap_rad": gap},), one_sided=known == 0.0, options=(("behind_encoder", behind),))
        for behind in sides
        for gap in (
            0.0001,
            0.00016,
            0.00025,
            0.0004,
            0.0006,
            0.001,
            0.0016,
            0.0025,
            0.004,
            0.006,
            0.01,
            0.02,
            0.04,
        )
    ]


CAUSE = Cause(
    id="gear_backlash",
    needs=driven,
    trials=_trials,
    free=free_of("drive.gap_rad"),
    parameters_of=lambda fit: plain(fit, gap_rad="drive.gap_rad"),
    settle={"drive.gap_rad": 0.0005},
)
