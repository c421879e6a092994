"""Play in the gear."""

from stillarm.common.causes.declaration import Cause, Parameter, size


def law(gap_rad: float) -> float:
    """Width of the play, rad."""
    return gap_rad


CAUSE = Cause(
    "gear_backlash",
    "drive",
    name="play in the gear",
    sees=(
        "after every reversal the joint stands still for a moment, then starts with a jerk that rings the arm"
    ),
    note="Where the encoder sits on the motor it shows nothing of this.",
    equation=(
        "play of total width gap: theta stands while the motor crosses the gap; the motor begins in "
        "its middle"
    ),
    parameters=(
        size("gap_rad", "rad", 1.0, 0.002, 0.01),
        Parameter("behind_encoder", "", default=False, kind="truth"),
    ),
    provoke="small moves to and fro, with pauses.",
    acts="play",
    law=law,
)
