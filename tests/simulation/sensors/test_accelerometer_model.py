"""What a device makes of the model file's accelerometer, and what the demo writes."""

from math import hypot, pi, sqrt
from pathlib import Path

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.files.model import Accelerometer, load_model
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.buses.parts import SENSED_PARTS
from stillarm.simulation.demo.set_up import write_demo_configuration
from stillarm.simulation.sensors.accelerometer_model import as_read, presented_by, with_device

ARM = Accelerometer(scale=-0.9, delay_s=0.0, noise_std_m_s2=0.5, bias_m_s2=0.1, range_m_s2=30.0)


def test_delay_range_and_noise_are_the_devices() -> None:
    device = AccelerometerDevice(driver="adxl355", full_scale_g=2)
    made = with_device(ARM, device)
    assert made.delay_s == 1.78e-3
    assert made.range_m_s2 == pytest.approx(2.048 * 9.80665)
    own = 25e-6 * 9.80665 * sqrt(pi / 2 * 250.0)
    assert made.noise_std_m_s2 == pytest.approx(hypot(0.5, own))
    assert (made.scale, made.bias_m_s2) == (-0.9, 0.1)
    assert with_device(ARM, AccelerometerDevice(driver="adxl355", full_scale_g=8)).range_m_s2 == 30.0


def test_a_slow_device_is_later_as_read() -> None:
    device = AccelerometerDevice(driver="witmotion")
    made = with_device(ARM, device)
    assert as_read(made, device, 0.001).delay_s == pytest.approx(made.delay_s + 0.002)
    fast = AccelerometerDevice(driver="lis3dh")
    assert as_read(ARM, fast, 0.001).delay_s == ARM.delay_s


def test_presented_keeps_the_mounting_and_finds_an_emulated_place() -> None:
    device = AccelerometerDevice(axis="x", sign=-1)
    presented = presented_by(device, "xsens")
    assert (presented.driver, presented.axis, presented.sign) == ("xsens", "x", -1)
    assert presented.bus.startswith("memory:") and presented.port.startswith("pty:")
    kept = presented_by(AccelerometerDevice(bus="memory:mine", port="pty:mine"), "lis3dh")
    assert (kept.bus, kept.port) == ("memory:mine", "pty:mine")
    with pytest.raises(UserError, match="no emulator"):
        presented_by(device, "iio")


@pytest.mark.parametrize("name", [*SENSED_PARTS, *SERIAL_DEVICES])
def test_the_demo_writes_both_models(tmp_path: Path, name: str) -> None:
    """The assumed and the true model differ only in the age of held samples."""
    _, configuration, _ = write_demo_configuration(tmp_path, 20.0, 0, name)
    assert configuration.accelerometer.driver == name
    assumed = load_model(tmp_path / "model.toml").accelerometer
    true = load_model(tmp_path / configuration.rig.model).accelerometer
    assert 0.0 <= true.delay_s <= assumed.delay_s < 0.006
    assert assumed.noise_std_m_s2 == true.noise_std_m_s2 >= 0.5
    rate_hz = TABLES[name].filters[0].rate_hz if name in TABLES else SERIAL_DEVICES[name].rate_hz
    slow = rate_hz < 1000.0
    assert (assumed.delay_s > true.delay_s) == slow


def test_the_default_demo_is_as_the_model_file_says(tmp_path: Path) -> None:
    _, configuration, _ = write_demo_configuration(tmp_path, 20.0, 0)
    assert not configuration.rig.model
    assert load_model(tmp_path / "model.toml").accelerometer.delay_s == 0.0


def test_a_name_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"^accelerometer 'adxl9': no emulator[^\n]*adxl355[^\n]*$"):
        write_demo_configuration(tmp_path, 20.0, 0, "adxl9")
