"""The ODrive driver against an emulated one on a pseudo terminal, on a clock that the test moves."""

from math import inf, isnan, pi

import msgspec
import pytest

from stillarm.common.files.configuration import DriveDevice, OdriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.odrive_drive import WATCHDOG_S, OdriveDrive
from stillarm.drivers.emulation.odrive_motor import OdriveMotor
from stillarm.drivers.emulation.pty_port import PtyPort

pytestmark = pytest.mark.usefixtures("handed_over")

GEAR = -20.0


class Bench:
    """Drive and emulated motor; whenever the driver sleeps, the motor answers and time passes."""

    def __init__(self, name: str) -> None:
        self.now = 100.0
        self.motor = OdriveMotor()
        self.config = DriveDevice(driver="odrive", gear_ratio=GEAR, odrive=OdriveDevice(port=f"pty:{name}"))
        self.port: PtyPort | None = PtyPort(self.config.odrive.port, "drive.odrive.port")
        self.drive = OdriveDrive(self.config, clock=lambda: self.now, sleep=self.sleep)

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.answer()

    def answer(self) -> float:
        """The motor's turn; returns what it follows, turns a second."""
        if self.port is not None:
            self.port.write(self.motor.receive(self.port.read(), self.now))
        return self.motor.velocity_command(self.now)

    def cycle(self, velocity: float) -> float:
        self.drive.command(velocity)
        followed = self.answer()
        self.drive.state()
        self.now += 0.001
        return followed

    def unplug(self) -> None:
        assert self.port is not None
        self.port.close()
        self.port = None

    def plug(self) -> None:
        """Back, with power lost: disarmed, its settings gone."""
        self.motor = OdriveMotor()
        self.port = PtyPort(self.config.odrive.port, "drive.odrive.port")


@pytest.fixture
def bench(request: pytest.FixtureRequest):
    bench = Bench(f"test-{request.node.name[:60].replace('[', '-').replace(']', '')}")
    yield bench
    bench.drive.close()
    if bench.port is not None:
        bench.port.close()


def test_commands_go_out_in_turns_of_the_motor_and_reports_come_back_in_radians_of_the_joint(bench):
    bench.drive.start()
    assert bench.motor.state == 8
    bench.motor.position_turns, bench.motor.velocity_turns_s = 1.5, -0.25
    assert bench.cycle(0.3) == pytest.approx(0.3 * GEAR / (2 * pi), abs=1e-6)
    state = bench.drive.state()
    assert state.position_rad == pytest.approx(1.5 * 2 * pi / GEAR)
    assert state.velocity_rad_s == pytest.approx(-0.25 * 2 * pi / GEAR)
    assert state.age_s <= 0.001 + 1e-9


def test_starting_moves_nothing(bench):
    bench.motor.properties["axis0.controller.config.control_mode"] = 3.0
    bench.drive.start()
    assert bench.answer() == 0.0 and bench.motor.properties["axis0.controller.config.control_mode"] == 2.0


def test_the_motor_stops_when_commands_cease_and_goes_on_only_after_a_command_of_zero(bench):
    bench.drive.start()
    assert bench.cycle(0.3) != 0.0
    bench.now += 1.1 * WATCHDOG_S
    assert bench.answer() == 0.0 and bench.motor.state == 1
    for _ in range(500):
        assert bench.cycle(0.3) == 0.0  # whoever commands on does not wake it
    assert bench.drive.state().age_s > 0.4
    for _ in range(300):
        bench.cycle(0.0)
    assert bench.motor.state == 8 and bench.drive.state().age_s < 0.05
    assert bench.cycle(0.3) != 0.0


def test_a_disarmed_axis_shows_as_a_lost_drive_within_50_ms(bench):
    bench.drive.start()
    for _ in range(50):
        bench.cycle(0.1)
    bench.motor.fail(0x40)
    cycles = 0
    while bench.drive.state().age_s < 0.03:
        bench.cycle(0.1)
        cycles += 1
        assert cycles < 45


def test_unplugged_and_plugged_again(bench):
    bench.drive.start()
    for _ in range(20):
        bench.cycle(0.1)
    bench.unplug()
    for _ in range(60):
        bench.drive.command(0.1)
        state = bench.drive.state()
        bench.now += 0.001
    assert state.age_s > 0.05
    for _ in range(1000):
        bench.drive.command(0.0)
        bench.drive.state()
        bench.now += 0.001
    bench.plug()
    for _ in range(1500):
        bench.cycle(0.0)
    assert bench.drive.reopened == 1 and bench.drive.state().age_s < 0.01
    assert bench.cycle(0.2) == pytest.approx(0.2 * GEAR / (2 * pi), abs=1e-6)


def test_garbage_is_counted_and_is_no_report(bench):
    bench.drive.start()
    bench.motor.garbage = True
    for _ in range(100):
        bench.cycle(0.1)
    assert bench.drive.corrupt_lines > 0 and bench.drive.state().age_s > 0.09
    bench.motor.garbage = False
    for _ in range(30):
        bench.cycle(0.1)
    assert bench.drive.state().age_s < 0.01


def test_close_commands_zero_and_disarms(bench):
    bench.drive.start()
    bench.cycle(0.3)
    bench.drive.close()
    bench.drive.close()
    assert bench.motor.state == 8
    # what was written before the port closed has arrived
    assert bench.answer() == 0.0 and bench.motor.state == 1


@pytest.mark.parametrize("value", [float("nan"), inf, -inf])
def test_what_is_no_number_goes_out_as_zero(bench, value):
    bench.drive.start()
    bench.cycle(0.3)
    assert bench.cycle(value) == 0.0 and bench.drive.refused == 1


def test_nobody_answers(bench):
    bench.motor.silent = True
    with pytest.raises(UserError, match=r"^drive\.odrive\.port = [^\n]*no ODrive answers[^\n]*$"):
        bench.drive.start()


def test_no_port():
    drive = OdriveDrive(DriveDevice(driver="odrive", odrive=OdriveDevice(port="/dev/ttyNONE9")))
    with pytest.raises(UserError, match=r"^drive\.odrive\.port = '/dev/ttyNONE9': no such port[^\n]*$"):
        drive.start()


def test_an_axis_that_does_not_arm_is_told(bench):
    bench.motor._set = lambda name, value: ""
    with pytest.raises(UserError, match=r"does not enter closed-loop control[^\n]*calibrate"):
        bench.drive.start()


def test_a_probe_arms_nothing(bench):
    bench.motor.position_turns = 2.0
    found = bench.drive.probe(0.1)
    assert found.identity.startswith("Hardware version") and found.reports > 10 and not found.notes
    assert found.position_rad == pytest.approx(2.0 * 2 * pi / GEAR)
    assert bench.motor.state == 1 and bench.motor.commands == 0


def test_a_uart_that_is_too_slow_is_told(bench):
    slow = msgspec.structs.replace(bench.config.odrive, port="/dev/ttyS7", baud=115200)
    (note,) = OdriveDrive(DriveDevice(driver="odrive", odrive=slow))._too_slow()
    assert note.startswith("drive.odrive.baud = 115200: an error")
    usb = msgspec.structs.replace(slow, port="/dev/ttyACM0")
    assert OdriveDrive(DriveDevice(driver="odrive", odrive=usb))._too_slow() == ()


def test_state_before_a_report_is_unknown(bench):
    bench.drive.start()
    bench.drive._position = float("nan")
    assert isnan(bench.drive.state().position_rad)
