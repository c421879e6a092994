"""Which actions are possible now, and the reason where one is not. Pure: the state machine's own table decides."""

from collections.abc import Callable
from typing import NamedTuple

from stillarm.controller.safety.adjusting import state_refusal
from stillarm.controller.safety.table import GROUND_OF, MOVING, TRANSITIONS, Event, Setting, State
from stillarm.panel.operate.actions import COMMANDS, Action


class Situation(NamedTuple):
    """The facts that decide. state, reason: the controller's words, empty before it was heard. silent: no telemetry
    now. signed_in: the page may operate. held: this panel holds the damping. damping_allowed: the controller's view.
    simulated: the rig is.
    """

    state: str = ""
    reason: str = ""
    silent: bool = True
    signed_in: bool = False
    held: bool = False
    damping_allowed: bool = True
    simulated: bool = False


READ_ONLY = "read-only: open the address with the token that the panel printed"
NO_CONTROLLER = "no controller is heard; start one with this configuration"


def refusal(action: Action, now: Situation) -> str:
    """Why an action is refused, in words for its button; empty where it is possible."""
    if not now.signed_in:
        return READ_ONLY
    if action is Action.STOP:
        return ""  # always sent: what is not heard may still move
    if _unheard(now):
        return NO_CONTROLLER
    return _WITHOUT_EVENT[action](now) if action in _WITHOUT_EVENT else _no_event(COMMANDS[action][1], now)


def setting_refusal(setting: Setting, now: Situation) -> str:
    """Why a setting may not be adjusted now; empty where it may."""
    if not now.signed_in:
        return READ_ONLY
    return NO_CONTROLLER if _unheard(now) else state_refusal(setting, State(now.state))


def _unheard(now: Situation) -> bool:
    return now.silent or now.state not in {str(state) for state in State}


def _no_allowing(now: Situation) -> str:
    if now.held:
        return ""
    if now.damping_allowed:
        return "damping is allowed already"
    return (
        "the schedule or the configuration does not allow damping now (controller.damping.without_schedule)"
    )


def _no_event(event: Event, now: Situation) -> str:
    state = State(now.state)
    if TRANSITIONS[state, event] is not state:
        return ""
    if event is Event.ARM:
        if state in MOVING:
            return f"armed already (state {state})"
        if state is State.FAULT:
            return "a fault must be cleared first"
        return f"the checks before arming do not hold yet{_because(now.reason)}"
    if event is Event.DISARM:
        return "nothing is armed"
    return "there is no fault to clear"


_WITHOUT_EVENT: dict[Action, Callable[[Situation], str]] = {
    Action.STRIKE: lambda now: (
        "" if now.simulated else "only a simulated rig is struck from here; strike this arm by hand"
    ),
    Action.HOLD_DAMPING: lambda now: "the damping is held already" if now.held else "",
    Action.ALLOW_DAMPING: _no_allowing,
}
"""The actions that the state machine's table does not know."""


def _because(reason: str) -> str:
    """The ground in words, with its remedy."""
    try:
        ground = GROUND_OF[Event(reason)]
    except (KeyError, ValueError):
        return ": the drive must report, the joint be within its limits, and the emergency stop be released"
    return f": {ground.message}; {ground.remedy}"


def words_of(reason: str) -> dict[str, str]:
    """A ground's message and remedy for the page; empty texts where nothing is wrong."""
    try:
        ground = GROUND_OF[Event(reason)]
    except (KeyError, ValueError):
        return {"message": reason, "remedy": ""}
    return {"message": ground.message, "remedy": ground.remedy}
