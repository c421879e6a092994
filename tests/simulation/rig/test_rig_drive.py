"""The rig's end of each drive, together with the driver that the controller uses."""

import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from math import isnan

import msgspec
import pytest

from stillarm.common.files.configuration import Cia402Device, DriveDevice, default_configuration_path
from stillarm.common.files.model import Mode, load_model
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import JointState
from stillarm.drivers.drives.drive_factory import open_drive
from stillarm.drivers.drives.drive_gateway import GatewayStatus
from stillarm.drivers.drives.odrive_drive import OdriveDrive
from stillarm.simulation.arm.plant import Plant
from stillarm.simulation.rig.rig_drive import rig_drive
from tests.fixtures.torque_model import FIRST, torque_model

KEY = b"a key of the tests' own"


def device(driver: str, name: str) -> DriveDevice:
    plain = DriveDevice()
    replace = msgspec.structs.replace
    return replace(
        plain,
        driver=driver,
        gear_ratio=-3.0,
        odrive=replace(plain.odrive, port=f"pty:{name}"),
        mcp4725=replace(plain.mcp4725, bus=f"memory:{name}"),
        cia402=Cia402Device(
            interface="virtual",
            channel=name,
            velocity_units_s_per_turn=65536.0,
            position_units_per_turn=65536.0,
        ),
    )


def settle(condition: Callable[[], bool]) -> None:
    """Until what was written has been carried over: a pseudo terminal's bytes wait for a worker of the kernel."""
    deadline = time.monotonic() + 120.0
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.0002)


def exchanged(rig, drive, velocity: float, now_s: float) -> tuple[float, JointState]:
    """A command brought to the rig, and its report back; what the rig then follows, and what the driver knows."""
    if not isinstance(drive, OdriveDrive):
        drive.command(velocity)
        return rig.poll(now_s), drive.state()
    commands, reports = rig.motor.commands, drive.reports
    drive.command(velocity)
    settle(lambda: rig.poll(now_s) is not None and rig.motor.commands > commands)
    settle(lambda: drive.state() is not None and drive.reports > reports)
    return rig.poll(now_s), drive.state()


@pytest.mark.parametrize("driver", ["odrive", "mcp4725"])
def test_the_joint_follows_what_the_driver_commands_and_stops_with_it(driver):
    config = device(driver, f"test-rig-drive-{driver}")
    rig = rig_drive(config, KEY)
    now = [10.0]

    def sleep(seconds: float) -> None:
        time.sleep(seconds)  # the port between the two takes real time
        now[0] += seconds
        rig.poll(now[0])

    drive = open_drive(config, KEY)
    drive._clock, drive._sleep = lambda: now[0], sleep
    drive.start()
    rig.poll(now[0])
    assert not rig.commanded
    rig.report(0.25, 0.5)
    for _ in range(5):
        followed, state = exchanged(rig, drive, 0.2, now[0])
        now[0] += 0.001
    assert rig.commanded and followed == pytest.approx(0.2, abs=0.0005)
    assert (
        isnan(state.position_rad)
        if driver == "mcp4725"
        else state.position_rad == pytest.approx(0.25, abs=1e-5)
    )
    assert rig.poll(now[0] + 0.2) == 0.0
    drive.close()
    assert rig.poll(now[0] + 0.2) == 0.0
    rig.close()
    rig.close()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"driver": "odrive", "odrive": {"port": "/dev/ttyACM0"}}, "drive.odrive.port = '/dev/ttyACM0'"),
        ({"driver": "cia402", "cia402": {"interface": "socketcan"}}, "drive.cia402.interface = 'socketcan'"),
        ({"driver": "mcp4725", "mcp4725": {"bus": "/dev/i2c-1"}}, "drive.mcp4725.bus = '/dev/i2c-1'"),
    ],
)
def test_the_rig_never_takes_a_real_port(change, words):
    with pytest.raises(UserError, match=words):
        rig_drive(msgspec.convert(change, DriveDevice), KEY)


def ring_down(exchange, seconds: float = 1.5) -> list[float]:
    """Deflection of a struck arm whose joint is commanded in proportion to it, as the damping does, through a drive.

    exchange: command and the joint's state to what the rig then follows, cycle by cycle.
    """
    plant = Plant(load_model(default_configuration_path().parent / "model.toml"))
    plant.strike(1, 0.00625)
    deflections = []
    for _ in range(round(seconds / plant.cycle_s)):
        command = 1.7 * plant.deflection_m
        plant.advance(exchange(command, plant.joint_position_rad, plant.joint_velocity_rad_s))
        deflections.append(plant.deflection_m)
    return deflections


@pytest.mark.parametrize("driver", ["odrive", "cia402", "mcp4725"])
def test_the_loop_closed_through_a_drive_settles_as_without_it(driver):
    if driver == "cia402":
        pytest.importorskip("can")
        pytest.importorskip("canopen")
    config = device(driver, f"test-closed-loop-{driver}")
    rig = rig_drive(config, KEY)
    now = [10.0]
    reported = []

    def sleep(seconds: float) -> None:
        time.sleep(seconds)  # the port between the two takes real time
        now[0] += seconds
        rig.poll(now[0])

    drive = open_drive(config, KEY)
    drive._clock, drive._sleep = lambda: now[0], sleep
    with answering(rig, now, driver == "cia402"):
        drive.start()

    def exchange(command: float, position: float, velocity: float) -> float:
        now[0] += 0.001
        rig.report(position, velocity)
        followed, state = exchanged(rig, drive, command, now[0])
        reported.append((state.position_rad, position))
        return followed

    through = ring_down(exchange)
    drive.close()
    rig.close()
    directly = ring_down(lambda command, position, velocity: command)
    freely = ring_down(lambda command, position, velocity: 0.0)
    late = slice(-400, None)  # the last 0.4 s: a period of the vibration
    left = [max(map(abs, run[late])) for run in (through, directly, freely)]
    assert left[1] < 0.4 * left[2]  # it does damp
    assert left[0] == pytest.approx(left[1], rel=0.05)
    if driver != "mcp4725":
        assert all(abs(told - true) < 2e-4 for told, true in reported[10:])


@contextmanager
def answering(rig, now: list[float], beside: bool):
    """The rig's answers while a set-up waits for them, from a thread where the set-up does not sleep by our clock."""
    done = threading.Event()

    def pump() -> None:
        while not done.is_set():
            rig.poll(now[0])
            time.sleep(0.0005)

    thread = threading.Thread(target=pump) if beside else None
    if thread is not None:
        thread.start()
    try:
        yield
    finally:
        done.set()
        if thread is not None:
            thread.join()


def test_a_torque_drive_behind_the_gateway_damps_a_struck_arm_through_our_velocity_loop():
    """Real sockets, virtual time; the joint is held or braked before, and braked after."""
    model = torque_model(Mode(modal_mass_kg=0.2), coulomb_n_m=0.5, bandwidth_hz=10.0)
    rig = rig_drive(DriveDevice(gateway_port=0, local_port=0), KEY, "torque")
    config = DriveDevice(gateway_port=rig._socket.address[1], local_port=0)
    drive, now = open_drive(config, KEY, model), [10.0]
    drive._clock = lambda: now[0]
    drive.start()
    plant = Plant(model)
    assert isnan(rig.poll(now[0]))
    damped, left_alone = [], []
    for series, gain in ((left_alone, 0.0), (damped, 1.7)):
        plant.strike(1, 0.00625)
        for _ in range(1500):
            now[0] += plant.cycle_s
            rig.report(plant.encoder_position_rad, plant.encoder_velocity_rad_s)
            drive.state()
            drive.command(gain * plant.deflection_m)
            plant.advance(rig.poll(now[0]))
            series.append(abs(plant.deflection_m))
    assert rig.commanded and drive.status == GatewayStatus.FOLLOWING
    assert max(damped[-400:]) < 0.3 * max(left_alone[-400:])
    drive.close()
    assert isnan(rig.poll(now[0]))
    rig.close()


@pytest.mark.parametrize("driver", ["odrive", "cia402", "mcp4725"])
def test_a_driver_of_velocities_refuses_a_joint_that_obeys_a_torque(driver):
    config = device(driver, "test-refused")
    with pytest.raises(UserError, match=f'drive.driver = "{driver}": commands velocities'):
        rig_drive(config, KEY, "torque")
    with pytest.raises(UserError, match=f'drive.driver = "{driver}": commands velocities'):
        open_drive(config, KEY, torque_model(FIRST))
