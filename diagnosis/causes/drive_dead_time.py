"""A longer dead time of the drive."""

from diagnosis.cause import Cause, Context, Trial, driven, free_of, plain

_BLURS = (0.0, 0.2)  # cycles


def _trials(context: Context) -> list[Trial]:
    """With the sharp edge of a simulation, and with that of a rig: where the dead time passes a whole number of cycles
    the acceleration read jumps by all of a command's step, unless sensor and drive blur it."""
    now, cycle_s = context.value("drive.dead_time_s"), context.world.measured.cycle_s
    return [
        Trial({"drive.blur_s": blur * cycle_s}, ({"drive.dead_time_s": now + more},))
        for more in (0.0005, 0.004, 0.015, 0.04)
        for blur in _BLURS
    ]


CAUSE = Cause(
    id="drive_dead_time",
    needs=driven,
    trials=_trials,
    free=free_of("drive.dead_time_s"),
    parameters_of=lambda fit: plain(fit, dead_time_s="drive.dead_time_s"),
)
