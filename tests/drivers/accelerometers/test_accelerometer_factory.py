"""The factory, and what it tells of a slow part."""

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.accelerometers.accelerometer_factory import held_samples_statement, open_accelerometer
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.register_tables import TABLES


def test_a_part_slower_than_the_loop_is_told() -> None:
    slow = open_accelerometer(AccelerometerDevice(driver="adxl345"))
    fast = open_accelerometer(AccelerometerDevice(driver="adxl355"))
    assert slow is not None and fast is not None
    statement = held_samples_statement(slow, 0.001)
    assert statement is not None and "800 samples a second for 1000 cycles" in statement
    assert held_samples_statement(fast, 0.001) is None


def test_factory() -> None:
    assert open_accelerometer(AccelerometerDevice(driver="none")) is None
    for part in TABLES:
        driver = open_accelerometer(AccelerometerDevice(driver=part), wait_s=0.0)  # type: ignore[arg-type]
        assert isinstance(driver, I2cAccelerometer)
        assert 0.0 < driver.delay_s < 0.005
