"""The CiA 402 driver against an emulated drive on a virtual CAN bus. Set-up runs beside a thread, the loop on a clock
that the test moves.
"""

from math import pi

import pytest

from tests.fixtures.cia402_bench import GEAR, VELOCITY

pytest.importorskip("canopen")

from stillarm.common.files.configuration import Cia402Device, DriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.cia402_set_up import DEAD_MAN_MS
from stillarm.drivers.drives.cia402_states import DriveState
from stillarm.drivers.drives.drive_factory import open_drive
from stillarm.drivers.emulation.cia402_node import Cia402Node


def test_walks_the_states_and_speaks_the_units(cia402):
    cia402.start()
    assert cia402.node.state == DriveState.ENABLED
    assert "profile" not in cia402.drive.identity and cia402.drive.identity.startswith("CiA 402")
    cia402.node.position_units, cia402.node.velocity_units_s = -2048, 500
    turns = cia402.cycle(0.3)
    assert turns == pytest.approx(0.3 * GEAR / (2 * pi), abs=0.5 / VELOCITY)
    state = cia402.drive.state()
    assert state.position_rad == pytest.approx(-0.5 * 2 * pi / GEAR)
    assert state.velocity_rad_s == pytest.approx(0.5 * 2 * pi / GEAR)
    assert state.age_s < 0.0011


def test_the_drive_stops_when_commands_cease_and_goes_on_only_after_a_command_of_zero(cia402):
    cia402.start()
    assert cia402.cycle(0.3) > 0.0
    cia402.now += 1.1 * DEAD_MAN_MS / 1000.0
    assert cia402.answer() == 0.0 and cia402.node.state == DriveState.QUICK_STOP
    for _ in range(200):
        assert cia402.cycle(0.3) == 0.0
    assert cia402.drive.state().age_s > 0.19
    for _ in range(10):
        cia402.cycle(0.0)
    assert cia402.node.state == DriveState.ENABLED
    assert cia402.cycle(0.3) > 0.0


def test_a_fault_shows_within_50_ms_and_is_reset_at_zero(cia402):
    cia402.start()
    for _ in range(20):
        cia402.cycle(0.1)
    cia402.node.fail(0x2310)
    for _ in range(45):
        cia402.cycle(0.1)
    assert cia402.drive.state().age_s > 0.04 and cia402.drive.drive_state == DriveState.FAULT
    for _ in range(20):
        cia402.cycle(0.0)
    assert cia402.node.state == DriveState.ENABLED and cia402.drive.state().age_s < 0.0011


def test_unplugged_and_plugged_again(cia402):
    cia402.start()
    cia402.cycle(0.1)
    cia402.away = True
    for _ in range(120):
        cia402.cycle(0.1)
    assert cia402.drive.state().age_s > 0.1
    cia402.away = False
    assert cia402.answer() == 0.0  # its dead man
    for _ in range(20):
        cia402.cycle(0.0)
    assert cia402.drive.state().age_s < 0.0011


def test_one_that_lost_its_power_stays_away(cia402):
    cia402.start()
    cia402.node = Cia402Node(7)
    for _ in range(100):
        cia402.cycle(0.0)
    assert cia402.drive.state().age_s > 0.09 and cia402.node.state == DriveState.DISABLED


def test_garbage_is_no_report(cia402):
    cia402.start()
    cia402.node.garbage = True
    for _ in range(60):
        cia402.cycle(0.0)
    assert cia402.drive.state().age_s > 0.05


def test_close_stops_the_drive(cia402):
    cia402.start()
    cia402.cycle(0.3)
    cia402.drive.close()
    cia402.drive.close()
    assert cia402.answer() == 0.0 and cia402.node.state == DriveState.QUICK_STOP


def test_what_is_no_number_goes_out_as_zero(cia402):
    cia402.start()
    cia402.cycle(0.3)
    assert cia402.cycle(float("nan")) == 0.0 and cia402.drive.refused == 1


def test_a_probe_changes_nothing(cia402):
    cia402.node.position_units = 4096
    before = dict(cia402.node._objects)
    found = cia402.beside(lambda: cia402.drive.probe(0.0))
    assert found.reports == 1 and found.position_rad == pytest.approx(2 * pi / GEAR)
    assert cia402.node._objects == before and cia402.node.commands == 0


def test_a_bus_that_is_not_there():
    drive = open_drive(
        DriveDevice(driver="cia402", cia402=Cia402Device(channel="can99")), b"a key of the tests"
    )
    with pytest.raises(UserError, match=r"drive\.cia402\.channel = 'can99': cannot be opened [^\n]*$"):
        drive.start()
