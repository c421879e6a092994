"""Setting up a drive by SDO: who answers, and which dead-man timer it has."""

import pytest

from stillarm.common.user_error import UserError
from stillarm.drivers.drives.cia402_set_up import DEAD_MAN_MS
from stillarm.drivers.drives.cia402_states import DriveState

pytest.importorskip("canopen")


def test_nobody_answers(cia402):
    cia402.node.silent = True
    with pytest.raises(UserError, match=r"^drive\.cia402\.node = 7: no drive answers [^\n]*$"):
        cia402.start()


def test_another_device_answers(cia402):
    cia402.node._objects[0x1000, 0] = 0x0004_0191
    with pytest.raises(UserError, match=r"profile 401 answers, not a CiA 402 drive"):
        cia402.start()


def test_a_drive_without_any_dead_man_is_refused(cia402):
    cia402.node.refused = {(0x1016, 1), (0x1400, 5)}
    with pytest.raises(UserError, match=r"monitors neither heartbeat \(1016\) nor RPDO1"):
        cia402.start()
    assert cia402.node.state == DriveState.DISABLED


@pytest.mark.parametrize("refused", [(0x1016, 1), (0x1400, 5)])
def test_one_dead_man_is_enough(cia402, refused):
    cia402.node.refused = {refused}
    cia402.start()
    cia402.cycle(0.3)
    cia402.now += 1.1 * DEAD_MAN_MS / 1000.0
    assert cia402.answer() == 0.0
