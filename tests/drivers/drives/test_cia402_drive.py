"""The CiA 402 driver against an emulated drive on a virtual CAN bus. Set-up runs beside a thread, the loop on a clock
that the test moves.
"""

import threading
import time
from math import pi

import pytest

can = pytest.importorskip("can")
pytest.importorskip("canopen")

from stillarm.common.files.configuration import Cia402Device, DriveDevice  # noqa: E402
from stillarm.common.user_error import UserError  # noqa: E402
from stillarm.drivers.drives.cia402_drive import Cia402Drive  # noqa: E402
from stillarm.drivers.drives.cia402_set_up import DEAD_MAN_MS  # noqa: E402
from stillarm.drivers.drives.cia402_states import DriveState, drive_state, next_control_word  # noqa: E402
from stillarm.drivers.drives.drive_factory import open_drive  # noqa: E402
from stillarm.drivers.emulation.cia402_node import Cia402Node  # noqa: E402

GEAR, VELOCITY, POSITION = 25.0, 1000.0, 4096.0


class Bench:
    """Driver and emulated drive on one bus."""

    def __init__(self, channel: str) -> None:
        self.now = 100.0
        self.node = Cia402Node(7)
        self.away = False
        device = Cia402Device(
            interface="virtual",
            channel=channel,
            node=7,
            velocity_units_s_per_turn=VELOCITY,
            position_units_per_turn=POSITION,
        )
        self.config = DriveDevice(driver="cia402", gear_ratio=GEAR, cia402=device)
        self.bus = can.Bus(interface="virtual", channel=channel)
        self.drive = Cia402Drive(self.config, clock=lambda: self.now, sleep=self.sleep)
        self.lock = threading.Lock()
        self.stop = False

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.answer()

    def answer(self) -> float:
        """The drive's turn; returns what it follows, turns a second of the motor."""
        with self.lock:
            while (message := self.bus.recv(0)) is not None:
                if self.away:
                    continue
                for identifier, data in self.node.receive(
                    message.arbitration_id, bytes(message.data), self.now
                ):
                    self.bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
            return self.node.velocity_command(self.now) / VELOCITY

    def beside(self, call):
        """Run a call that waits for the drive's answers."""

        def pump() -> None:
            while not self.stop:
                self.answer()
                time.sleep(0.0005)

        self.stop = False
        thread = threading.Thread(target=pump)
        thread.start()
        try:
            return call()
        finally:
            self.stop = True
            thread.join()

    def start(self) -> None:
        self.beside(self.drive.start)

    def cycle(self, velocity: float) -> float:
        self.drive.command(velocity)
        followed = self.answer()
        self.drive.state()
        self.now += 0.001
        return followed


@pytest.fixture
def bench(request: pytest.FixtureRequest):
    bench = Bench(f"test-{request.node.name}")
    yield bench
    bench.drive.close()
    bench.bus.shutdown()


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


def test_walks_the_states_and_speaks_the_units(bench):
    bench.start()
    assert bench.node.state == DriveState.ENABLED
    assert "profile" not in bench.drive.identity and bench.drive.identity.startswith("CiA 402")
    bench.node.position_units, bench.node.velocity_units_s = -2048, 500
    turns = bench.cycle(0.3)
    assert turns == pytest.approx(0.3 * GEAR / (2 * pi), abs=0.5 / VELOCITY)
    state = bench.drive.state()
    assert state.position_rad == pytest.approx(-0.5 * 2 * pi / GEAR)
    assert state.velocity_rad_s == pytest.approx(0.5 * 2 * pi / GEAR)
    assert state.age_s < 0.0011


def test_the_drive_stops_when_commands_cease_and_goes_on_only_after_a_command_of_zero(bench):
    bench.start()
    assert bench.cycle(0.3) > 0.0
    bench.now += 1.1 * DEAD_MAN_MS / 1000.0
    assert bench.answer() == 0.0 and bench.node.state == DriveState.QUICK_STOP
    for _ in range(200):
        assert bench.cycle(0.3) == 0.0
    assert bench.drive.state().age_s > 0.19
    for _ in range(10):
        bench.cycle(0.0)
    assert bench.node.state == DriveState.ENABLED
    assert bench.cycle(0.3) > 0.0


def test_a_fault_shows_within_50_ms_and_is_reset_at_zero(bench):
    bench.start()
    for _ in range(20):
        bench.cycle(0.1)
    bench.node.fail(0x2310)
    for _ in range(45):
        bench.cycle(0.1)
    assert bench.drive.state().age_s > 0.04 and bench.drive.drive_state == DriveState.FAULT
    for _ in range(20):
        bench.cycle(0.0)
    assert bench.node.state == DriveState.ENABLED and bench.drive.state().age_s < 0.0011


def test_unplugged_and_plugged_again(bench):
    bench.start()
    bench.cycle(0.1)
    bench.away = True
    for _ in range(120):
        bench.cycle(0.1)
    assert bench.drive.state().age_s > 0.1
    bench.away = False
    assert bench.answer() == 0.0  # its dead man
    for _ in range(20):
        bench.cycle(0.0)
    assert bench.drive.state().age_s < 0.0011


def test_one_that_lost_its_power_stays_away(bench):
    bench.start()
    bench.node = Cia402Node(7)
    for _ in range(100):
        bench.cycle(0.0)
    assert bench.drive.state().age_s > 0.09 and bench.node.state == DriveState.DISABLED


def test_garbage_is_no_report(bench):
    bench.start()
    bench.node.garbage = True
    for _ in range(60):
        bench.cycle(0.0)
    assert bench.drive.state().age_s > 0.05


def test_close_stops_the_drive(bench):
    bench.start()
    bench.cycle(0.3)
    bench.drive.close()
    bench.drive.close()
    assert bench.answer() == 0.0 and bench.node.state == DriveState.QUICK_STOP


def test_what_is_no_number_goes_out_as_zero(bench):
    bench.start()
    bench.cycle(0.3)
    assert bench.cycle(float("nan")) == 0.0 and bench.drive.refused == 1


def test_nobody_answers(bench):
    bench.node.silent = True
    with pytest.raises(UserError, match=r"^drive\.cia402\.node = 7: no drive answers [^\n]*$"):
        bench.start()


def test_another_device_answers(bench):
    bench.node._objects[0x1000, 0] = 0x0004_0191
    with pytest.raises(UserError, match=r"profile 401 answers, not a CiA 402 drive"):
        bench.start()


def test_a_drive_without_any_dead_man_is_refused(bench):
    bench.node.refused = {(0x1016, 1), (0x1400, 5)}
    with pytest.raises(UserError, match=r"monitors neither heartbeat \(1016\) nor RPDO1"):
        bench.start()
    assert bench.node.state == DriveState.DISABLED


@pytest.mark.parametrize("refused", [(0x1016, 1), (0x1400, 5)])
def test_one_dead_man_is_enough(bench, refused):
    bench.node.refused = {refused}
    bench.start()
    bench.cycle(0.3)
    bench.now += 1.1 * DEAD_MAN_MS / 1000.0
    assert bench.answer() == 0.0


def test_a_probe_changes_nothing(bench):
    bench.node.position_units = 4096
    before = dict(bench.node._objects)
    found = bench.beside(lambda: bench.drive.probe(0.0))
    assert found.reports == 1 and found.position_rad == pytest.approx(2 * pi / GEAR)
    assert bench.node._objects == before and bench.node.commands == 0


def test_a_bus_that_is_not_there():
    drive = open_drive(
        DriveDevice(driver="cia402", cia402=Cia402Device(channel="can99")), b"a key of the tests"
    )
    with pytest.raises(UserError, match=r"drive\.cia402\.channel = 'can99': cannot be opened [^\n]*$"):
        drive.start()
