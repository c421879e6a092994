"""The operator's actions: what each does, and what the page asks before it."""

from enum import StrEnum
from typing import NamedTuple

from stillarm.controller.safety.table import Event, Operator


class Action(StrEnum):
    """What a page may ask for."""

    STOP = "stop"
    ARM = "arm"
    DISARM = "disarm"
    CLEAR = "clear"
    HOLD_DAMPING = "hold_damping"
    ALLOW_DAMPING = "allow_damping"
    STRIKE = "strike"


class Meaning(NamedTuple):
    """label: on the button. does: in one sentence. asks: the question before something moves; empty: none."""

    label: str
    does: str
    asks: str


MEANINGS = {
    Action.STOP: Meaning("Stop", "The command is zero at once, until Clear and Arm.", ""),
    Action.ARM: Meaning(
        "Arm",
        "The joint may move, and damps if damping is allowed.",
        "The joint may move from now on. Is everybody out of the arm's reach?",
    ),
    Action.DISARM: Meaning("Disarm", "The command fades to zero, and the joint stays still.", ""),
    Action.CLEAR: Meaning(
        "Clear fault",
        "Acknowledges the fault; Arm is needed next.",
        "Has the cause of the fault been removed?",
    ),
    Action.HOLD_DAMPING: Meaning(
        "Hold damping",
        "The damping fades out for as long as this panel runs and says so; it is no safety function.",
        "",
    ),
    Action.ALLOW_DAMPING: Meaning(
        "Allow damping",
        "The damping fades in when it has something to act on.",
        "The joint will move to damp the arm. Is everybody out of its reach?",
    ),
    Action.STRIKE: Meaning(
        "Strike",
        "The simulated arm receives a blow at its tip and rings.",
        "The simulated arm will be struck and ring. Go on?",
    ),
}

COMMANDS = {
    Action.STOP: (Operator.EMERGENCY_STOP, Event.EMERGENCY_STOP),
    Action.ARM: (Operator.ARM, Event.ARM),
    Action.DISARM: (Operator.DISARM, Event.DISARM),
    Action.CLEAR: (Operator.CLEAR, Event.CLEAR),
}
"""The operator's bits that an action sends, and the event of the state machine's table."""
