"""Friction in the joint."""

from stillarm.common.causes.declaration import Cause, size


def law(command: float, velocity_loss_rad_s: float) -> float:
    """The command that the drive obeys, rad/s."""
    if command > 0.0:
        return max(0.0, command - velocity_loss_rad_s)
    return min(0.0, command + velocity_loss_rad_s)


CAUSE = Cause(
    "joint_friction",
    "drive",
    name="friction in the joint",
    sees=(
        "the joint is slower than its command by the same amount at every speed, and does not move at "
        "all for commands below that"
    ),
    equation="a command c is obeyed as sign(c) max(0, |c| - loss)",
    parameters=(size("velocity_loss_rad_s", "rad/s", 10.0, 0.005, 0.02),),
    provoke="slow moves to and fro, at several velocities.",
    acts="command",
    law=law,
)
