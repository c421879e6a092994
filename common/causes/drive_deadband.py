"""A drive that ignores small commands."""

from stillarm.common.causes.declaration import Cause, size


def law(command: float, deadband_rad_s: float) -> float:
    """The command that the drive obeys, rad/s."""
    return 0.0 if -deadband_rad_s <= command <= deadband_rad_s else command


CAUSE = Cause(
    "drive_deadband",
    "drive",
    name="a drive that ignores small commands",
    sees="small commands do nothing at all, larger ones are obeyed in full",
    note="Near standstill it looks like joint_friction.",
    equation="a command of |c| <= deadband is obeyed as 0, others unchanged",
    parameters=(size("deadband_rad_s", "rad/s", 10.0, 0.005, 0.02),),
    provoke="slow moves to and fro, at several velocities.",
    acts="command",
    law=law,
    confused_with={
        "joint_friction": (
            "reverse the joint slowly several times, at speeds from a tenth of to three times the "
            "smallest speed it obeys: a dead band stops below one speed and loses nothing above it, "
            "friction loses the same at every speed"
        ),
    },
)
