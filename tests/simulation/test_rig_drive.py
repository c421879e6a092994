"""The rig's end of each drive, together with the driver that the controller uses."""

from math import isnan

import msgspec
import pytest

from common.configuration import Cia402Device, DriveDevice
from common.user_error import UserError
from drivers.drive_factory import open_drive
from simulation.rig_drive import rig_drive

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
        cia402=Cia402Device(interface="virtual", channel=name),
    )


@pytest.mark.parametrize("driver", ["odrive", "mcp4725"])
def test_the_joint_follows_what_the_driver_commands_and_stops_with_it(driver):
    config = device(driver, f"test-rig-drive-{driver}")
    rig = rig_drive(config, KEY)
    now = [10.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds
        rig.poll(now[0])

    drive = open_drive(config, KEY)
    drive._clock, drive._sleep = lambda: now[0], sleep
    drive.start()
    rig.poll(now[0])
    assert not rig.commanded
    rig.report(0.25, 0.5)
    for _ in range(5):
        drive.command(0.2)
        followed = rig.poll(now[0])
        state = drive.state()
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
