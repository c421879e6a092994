"""The state machine of CiA 402 drives as values: takes a status word, returns the next control word (CiA 402-2)."""

from enum import StrEnum

DISABLE, SHUTDOWN, SWITCH_ON, ENABLE = 0x00, 0x06, 0x07, 0x0F
QUICK_STOP, FAULT_RESET = 0x02, 0x80


class DriveState(StrEnum):
    """The states of object 6041."""

    NOT_READY = "not ready to switch on"
    DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"
    UNKNOWN = "unknown"


_BY_4F = {
    0x00: DriveState.NOT_READY,
    0x40: DriveState.DISABLED,
    0x0F: DriveState.FAULT_REACTION,
    0x08: DriveState.FAULT,
}
_BY_6F = {
    0x21: DriveState.READY,
    0x23: DriveState.SWITCHED_ON,
    0x27: DriveState.ENABLED,
    0x07: DriveState.QUICK_STOP,
}
_ON = {
    DriveState.DISABLED: SHUTDOWN,
    DriveState.READY: SWITCH_ON,
    DriveState.SWITCHED_ON: ENABLE,
    DriveState.ENABLED: ENABLE,
}


def drive_state(status_word: int) -> DriveState:
    """The state that a status word (6041) encodes."""
    return _BY_6F.get(status_word & 0x6F) or _BY_4F.get(status_word & 0x4F, DriveState.UNKNOWN)


def next_control_word(state: DriveState, last: int) -> int:
    """The control word (6040) that leads a drive towards operation enabled. last: the previous control word.

    The rising edge of bit 7 resets a fault, so that the bit must fall in between. The exit from a quick stop is by
    'switch on disabled', which every drive allows.
    """
    if state == DriveState.FAULT:
        return DISABLE if last & FAULT_RESET else FAULT_RESET
    return _ON.get(state, DISABLE)
