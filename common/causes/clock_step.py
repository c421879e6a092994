"""A clock that stepped."""

from stillarm.common.causes.declaration import ONSET, Cause, Parameter, size


def law(t: float, onset_s: float, step_s: float) -> float:
    """What the clock has jumped by, s."""
    return step_s if t >= onset_s else 0.0


CAUSE = Cause(
    "clock_step",
    "timing",
    name="a clock that stepped",
    sees=(
        "one clock jumps against the others at an instant: that which dates the frames' arrival, the "
        "camera's own, or the controller's altogether"
    ),
    note=(
        "Stamps taken before the onset stay as they are. `simulate` does all three: the rows of the "
        "recording carry the stepped times, while cycle numbers and the loop go on undisturbed, so "
        "that a replay gives the same numbers. A live rig has no hand in the controller's clock and "
        'refuses "frames" and "all"; it steps the camera\'s stamps. "camera" needs `rig.scene.stamped '
        "= true` in the configuration."
    ),
    equation=(
        "at the onset step is added to received_s and started_s (frames), to captured_s (camera), to "
        "every time in both files (all)"
    ),
    parameters=(
        ONSET,
        size("step_s", "s", 10.0, 0.02, 0.2, signed=True),
        Parameter("clock", "", default="frames", kind="text", choices=("frames", "camera", "all")),
    ),
    provoke="any recording with the arm ringing around the onset.",
    acts="clock",
    law=law,
    repeatable=True,
)
