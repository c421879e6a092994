"""The tables of states: the transitions, and the reaction to each missing ground.

Health and permission are separate. Health is the list `GROUNDS`, checked in each cycle. The operator gives permission,
or `controller.arm_at_start` at the start; a fault withdraws it. docs/safety.md shows both tables, and a test compares
them.
"""

from enum import IntFlag, StrEnum
from typing import NamedTuple


class State(StrEnum):
    """The controller's state. The joint may move in ARMED, DAMPING and DEGRADED only."""

    PREFLIGHT = "preflight"  # a required part is still missing
    IDLE = "idle"  # all parts are present; the operator has not armed
    ARMED = "armed"  # the reference moves the joint; damping is off or has nothing to act on
    DAMPING = "damping"
    DEGRADED = "degraded"  # a part is missing: reduced operation until it is back
    FAULT = "fault"  # at rest until the operator clears the fault


class Event(StrEnum):
    """The events. The controller itself detects those in the table of grounds."""

    READY = "ready"  # the checks before arming pass
    ARM = "arm"
    DISARM = "disarm"
    CLEAR = "clear"
    DAMPING_BEGUN = "damping begun"
    DAMPING_ENDED = "damping ended"
    HEALTHY = "healthy"  # no ground has been missing for 0.2 s
    EMERGENCY_STOP = "emergency stop"
    NON_FINITE = "non-finite numbers"
    GROWING = "growing vibration"
    SATURATED = "saturated"
    DRIVE_LOST = "drive lost"
    DRIVE_SILENT = "drive silent"
    LOOP_STALLED = "loop stalled"
    DEADLINES_MISSED = "deadlines missed"
    VISION_STALE = "vision stale"
    ACCELEROMETER_DEAD = "accelerometer dead"
    UNCOMMISSIONED = "uncommissioned"


class Operator(IntFlag):
    """The operator's requests in a cycle; EMERGENCY_STOP stays set while the switch is held."""

    ARM = 1
    DISARM = 2
    CLEAR = 4
    EMERGENCY_STOP = 8


class Reaction(StrEnum):
    """The reaction of the command, or of its damping part, to a missing ground."""

    HOLD = "hold"  # continue with the last known value
    FADE = "fade"  # to zero, steadily
    ZERO = "zero"  # at once, as fast as the acceleration limit allows


class Ground(NamedTuple):
    """A missing ground, and its consequences.

    whole: whether it affects the whole command, or its damping part only
    seen_within_s: time from the event to its detection; zero_within_s: from then until the command (part) is zero
    """

    event: Event
    whole: bool
    reaction: Reaction
    seen_within_s: float
    zero_within_s: float
    message: str
    remedy: str


# In order of severity: the first missing one is reported as the reason.
GROUNDS = (
    Ground(
        Event.EMERGENCY_STOP, True, Reaction.ZERO, 0.001, 0.04,
        "emergency stop",
        "release the switch, see that the arm is free, then `stillarm operate clear` and `arm`",
    ),
    Ground(
        Event.NON_FINITE, True, Reaction.ZERO, 0.05, 0.04,
        "the estimate is not a finite number",
        "restart the controller; keep the recording, and replay it to find the sample that caused this",
    ),
    Ground(
        Event.GROWING, True, Reaction.FADE, 2.0, 0.1,
        "the vibration grows while it is damped",
        "check the signs of accelerometer.scale, camera.scale_px_per_m and participation, the drive's direction and "
        "timing.capture_delay_s (`stillarm calibrate`), then `stillarm operate clear` and `arm`",
    ),
    Ground(
        Event.SATURATED, True, Reaction.FADE, 5.0, 0.1,
        "the damping has been at its limit for a long time without reducing the vibration",
        "lower controller.damping.added_damping_ratio, or raise max_velocity_rad_s as far as the drive allows; "
        "then `stillarm operate clear` and `arm`",
    ),
    Ground(
        Event.DRIVE_LOST, True, Reaction.ZERO, 1.0, 0.04,
        "the drive has not reported for a second",
        "check the gateway's power, cable and drive.gateway_host; operation resumes from the preflight",
    ),
    Ground(
        Event.DRIVE_SILENT, True, Reaction.ZERO, 0.05, 0.04,
        "the drive does not report",
        "check the gateway's power and cable; motion resumes by itself with the reports",
    ),
    Ground(
        Event.LOOP_STALLED, True, Reaction.ZERO, 0.001, 0.04,
        "the loop stood still for more than 0.05 s",
        "see what else runs on this computer; give the controller its real-time privileges (`stillarm latency`)",
    ),
    Ground(
        Event.DEADLINES_MISSED, False, Reaction.FADE, 1.0, 0.05,
        "more than a quarter of the last second's cycles were missed",
        "see what else runs on this computer; give the controller its real-time privileges (`stillarm latency`)",
    ),
    Ground(
        Event.VISION_STALE, False, Reaction.FADE, 0.1, 0.05,
        "no image has been measured for controller.damping.stale_after_s",
        "check the supervisor, the camera's light and view, and the link; damping resumes with the images",
    ),
    Ground(
        Event.ACCELEROMETER_DEAD, False, Reaction.HOLD, 0.05, 0.0,
        "the accelerometer delivers no samples; damping continues with the last known capture delay",
        "check its bus and power; to run without it for long, set controller.method to one that needs none",
    ),
    Ground(
        Event.UNCOMMISSIONED, False, Reaction.ZERO, 0.001, 0.04,
        "the model file was not identified on this rig, so the rig is not damped",
        "`stillarm commission --config FILE -o MODEL` identifies it; name MODEL as the configuration's model",
    ),
)  # fmt: skip
GROUND_OF = {ground.event: ground for ground in GROUNDS}
BIT_OF = {ground.event: 1 << place for place, ground in enumerate(GROUNDS)}

_TABLE = """
event               preflight  idle       armed      damping    degraded   fault
ready               idle       .          .          .          .          .
arm                 .          armed      .          .          .          .
disarm              .          .          idle       idle       idle       .
clear               .          .          .          .          .          preflight
damping begun       .          .          damping    .          .          .
damping ended       .          .          .          armed      .          .
healthy             .          .          .          .          armed      .
emergency stop      fault      fault      fault      fault      fault      .
non-finite numbers  .          .          fault      fault      fault      .
growing vibration   .          .          fault      fault      fault      .
saturated           .          .          fault      fault      fault      .
drive lost          .          preflight  preflight  preflight  preflight  .
drive silent        .          .          degraded   degraded   .          .
loop stalled        .          .          degraded   degraded   .          .
deadlines missed    .          .          degraded   degraded   .          .
vision stale        .          .          degraded   degraded   .          .
accelerometer dead  .          .          degraded   degraded   .          .
uncommissioned      .          .          degraded   degraded   .          .
"""


def _parse(table: str) -> dict[tuple[State, Event], State]:
    """The transitions from the table's text; a dot means no change."""
    head, *rows = table.strip().splitlines()
    states = [State(word) for word in head.split()[1:]]
    found = {}
    for row in rows:
        words = row.split()
        event, nexts = Event(" ".join(words[: -len(states)])), words[-len(states) :]
        for state, following in zip(states, nexts, strict=True):
            found[state, event] = state if following == "." else State(following)
    return found


TRANSITIONS = _parse(_TABLE)


class Setting(StrEnum):
    """What an operator may adjust while the controller runs."""

    GAIN = "gain"
    METHOD = "method"


_ADJUSTING = """
setting  preflight  idle  armed  damping  degraded  fault
gain     yes        yes   yes    yes      .         yes
method   yes        yes   yes    .        .         yes
"""


def _parse_adjusting(table: str) -> frozenset[tuple[Setting, State]]:
    """Where a setting may be adjusted, from the table's text."""
    head, *rows = (line.split() for line in table.strip().splitlines())
    states = [State(word) for word in head[1:]]
    return frozenset(
        (Setting(setting), state)
        for setting, *words in rows
        for state, word in zip(states, words, strict=True)
        if word == "yes"
    )


MAY_ADJUST = _parse_adjusting(_ADJUSTING)
"""The settings and the states in which they may be adjusted. The gain goes over at zero damping, faded out and in; a
method has to find the delay anew, so that nothing may be damped by it meanwhile.
"""
MOVING = frozenset({State.ARMED, State.DAMPING, State.DEGRADED})
"""The states in which the command may be non-zero."""
