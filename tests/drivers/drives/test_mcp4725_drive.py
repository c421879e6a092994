"""The DAC's driver against an emulated MCP4725 on a bus in memory."""

from math import isnan, pi

import pytest

from stillarm.common.files.configuration import DriveDevice, Mcp4725Device
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.mcp4725_drive import Mcp4725Drive
from stillarm.drivers.emulated_chips.mcp4725_chip import Mcp4725Output


class Clock:
    now = 50.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.fixture
def parts(request: pytest.FixtureRequest):
    name = "test-" + "".join(c if c.isalnum() else "-" for c in request.node.name)
    output = Mcp4725Output(name)
    clock = Clock()
    config = DriveDevice(
        driver="mcp4725", gear_ratio=2.0, mcp4725=Mcp4725Device(bus=f"memory:{name}", turns_s_per_v=-0.1)
    )
    drive = Mcp4725Drive(config, wait_s=0.0, clock=clock, sleep=clock.sleep)
    yield drive, output, clock, config
    drive.close()
    output.close()


def test_velocity_is_a_voltage(parts):
    drive, output, _, _ = parts
    drive.start()
    assert output.output()[1] == 2048
    drive.command(0.3)
    volts = 2.5 + 0.3 * 2.0 / (2 * pi) / -0.1
    assert output.output()[1] == round(volts * 4096 / 5.0)


@pytest.mark.parametrize(("velocity", "code"), [(1e9, 0), (-1e9, 4095), (float("nan"), 2048)])
def test_codes_keep_their_range(parts, velocity, code):
    drive, output, _, _ = parts
    drive.start()
    drive.command(velocity)
    assert output.output()[1] == code


def test_nothing_comes_back_but_the_acknowledge(parts):
    drive, output, clock, _ = parts
    drive.start()
    drive.command(0.1)
    clock.now += 0.02
    state = drive.state()
    assert isnan(state.position_rad) and isnan(state.velocity_rad_s) and state.age_s == pytest.approx(0.02)
    output.unplug(True)
    for _ in range(60):
        drive.command(0.1)
        clock.now += 0.001
    assert drive.state().age_s > 0.05 and drive.faults == 60
    output.unplug(False)
    drive.command(0.0)
    assert drive.state().age_s == 0.0


def test_close_commands_zero(parts):
    drive, output, _, _ = parts
    drive.start()
    drive.command(0.3)
    drive.close()
    drive.close()
    assert output.output()[1] == 2048


def test_nobody_answers_at_another_address(parts):
    _, _, _, config = parts
    other = DriveDevice(driver="mcp4725", mcp4725=Mcp4725Device(bus=config.mcp4725.bus, address=0x60))
    with pytest.raises(UserError, match=r"drive\.mcp4725\.address = 0x60: no MCP4725 answers [^\n]*$"):
        Mcp4725Drive(other, wait_s=0.0).start()


def test_no_bus():
    config = DriveDevice(driver="mcp4725", mcp4725=Mcp4725Device(bus="/dev/i2c-77"))
    with pytest.raises(UserError, match=r"^drive\.mcp4725\.bus = '/dev/i2c-77': no such bus[^\n]*$"):
        Mcp4725Drive(config).start()


def test_a_probe_reads_only_and_tells_what_power_up_would_do(parts):
    drive, output, _, _ = parts
    before = output.output()
    found = drive.probe(0.1)
    assert found.reports > 10 and len(found.notes) == 1 and "dead-man timer" in found.notes[0]
    assert output.output() == before
    output.close()
    name = drive._config.bus.removeprefix("memory:")
    moved = Mcp4725Output(name, power_up_code=0)
    notes = drive.probe(0.1).notes
    moved.close()
    assert "EEPROM holds code 0" in notes[1] and "write code 2048" in notes[1]
