"""The state machine of CiA 402, as the standard's table has it."""

import pytest

from stillarm.drivers.drives.cia402_states import DriveState, drive_state, next_control_word

pytest.importorskip("canopen")


@pytest.mark.parametrize(
    ("word", "state"),
    [
        (0x0000, DriveState.NOT_READY),
        (0x0240, DriveState.DISABLED),
        (0x0231, DriveState.READY),
        (0x0233, DriveState.SWITCHED_ON),
        (0x0637, DriveState.ENABLED),
        (0x0617, DriveState.QUICK_STOP),
        (0x020F, DriveState.FAULT_REACTION),
        (0x0218, DriveState.FAULT),
    ],
)
def test_states_after_the_standard_s_table(word, state):
    assert drive_state(word) == state


def test_a_fault_is_reset_by_a_rising_edge():
    assert next_control_word(DriveState.FAULT, 0x0F) == 0x80
    assert next_control_word(DriveState.FAULT, 0x80) == 0x00


def test_every_state_word_is_a_state():
    for word in range(1 << 16):
        assert next_control_word(drive_state(word), 0) in (0x00, 0x06, 0x07, 0x0F, 0x80)
