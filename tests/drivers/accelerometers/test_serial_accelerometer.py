"""The driver of the serial accelerometers on emulated ports: every device, every failure."""

import os
from collections.abc import Callable, Iterator
from math import isnan
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer import SampleStatus
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.accelerometers.serial_accelerometer import SerialAccelerometer
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.buses.serial_port import port_path
from stillarm.drivers.emulated_chips.shared_registers import Failure
from stillarm.drivers.emulation.serial_accelerometer_device import EmulatedSerialAccelerometer

PORT = f"pty:test-serial-accelerometer-{os.getpid()}"
NAMES = sorted(SERIAL_DEVICES)
pytestmark = pytest.mark.usefixtures("handed_over")
EVERY = pytest.mark.parametrize("name", NAMES)
SLOWEST_M_S2 = 0.005  # a count of the coarsest device


class Rig:
    """Emulated device, driver, and a clock that moves by a cycle with every sample felt."""

    def __init__(self, name: str, **config: Any) -> None:
        self.config = AccelerometerDevice(driver=name, port=PORT, **config)  # type: ignore[arg-type]
        self.device = EmulatedSerialAccelerometer(name, PORT)
        self.now_s = 1000.0
        self.value = 0.0
        self.driver = SerialAccelerometer(
            self.config, SERIAL_DEVICES[name], wait_s=1.0, sleep=self.sleep, clock=lambda: self.now_s
        )

    def sleep(self, duration_s: float) -> None:
        for _ in range(max(1, round(duration_s / 0.001))):
            self.feel(self.value)

    def feel(self, acceleration_m_s2: float) -> None:
        self.now_s += 0.001
        self.device.publish(sensed_axes(acceleration_m_s2, self.config))

    def cycles(self, acceleration_m_s2: float, count: int) -> list[float]:
        self.value = acceleration_m_s2
        seen = []
        for _ in range(count):
            self.feel(acceleration_m_s2)
            seen.append(self.driver.read())
        return seen

    def close(self) -> None:
        self.driver.close()
        self.device.close()


@pytest.fixture
def rig() -> Iterator[Callable[..., Rig]]:
    made: list[Rig] = []

    def make(name: str, *, start: bool = True, **config: Any) -> Rig:
        made.append(Rig(name, **config))
        if start:
            made[-1].driver.start()
        return made[-1]

    yield make
    for each in made:
        each.close()


@EVERY
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_reads_each_axis(rig: Callable[..., Rig], name: str, axis: str) -> None:
    made = rig(name, axis=axis, sign=-1, bias_m_s2=0.5)
    assert made.cycles(3.2, 30)[-1] == pytest.approx(3.2 - 0.5, abs=SLOWEST_M_S2)
    assert made.cycles(-7.7, 30)[-1] == pytest.approx(-7.7 - 0.5, abs=SLOWEST_M_S2)
    assert made.driver.faults == 0
    reading = made.driver.last_reading()
    assert reading.acceleration_xyz_m_s2["xyz".index(axis)] == pytest.approx(7.7, abs=SLOWEST_M_S2)
    assert isnan(reading.device_time_s) == (name == "witmotion")


@EVERY
def test_start_sets_the_rate_that_the_table_says(rig: Callable[..., Rig], name: str) -> None:
    made = rig(name)
    before = made.driver._decoder.frames
    made.cycles(1.0, 1000)
    assert made.driver._decoder.frames - before == pytest.approx(SERIAL_DEVICES[name].rate_hz, abs=4)
    assert "frames received, 0 false starts" in made.driver.identify() or name == "vectornav"


@pytest.mark.slow
@EVERY
@pytest.mark.parametrize("failure", [Failure.STUCK, Failure.GARBAGE, Failure.UNPLUGGED])
def test_a_device_that_went_away_comes_back_by_itself(
    rig: Callable[..., Rig], name: str, failure: Failure
) -> None:
    made = rig(name)
    made.cycles(1.0, 20)
    made.device.inject(failure)
    away = made.cycles(2.0, 1500)
    # A WitMotion's checksum is a sum of 8 bits: of 256 garbage frames it takes one.
    assert sum(not isnan(value) for value in away[30:]) <= (100 if name == "witmotion" else 0)
    assert made.driver.faults >= 1300
    made.device.inject(Failure.NONE)
    back = made.cycles(3.0, 1500)
    assert back[-1] == pytest.approx(3.0, abs=SLOWEST_M_S2)
    assert all(not isnan(value) for value in back[-200:])


@pytest.mark.slow
@EVERY
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    troubles=st.lists(
        st.tuples(
            st.sampled_from([Failure.STUCK, Failure.GARBAGE, Failure.LATE, Failure.UNPLUGGED, Failure.NONE]),
            st.integers(1, 400),
        ),
        max_size=4,
    )
)
@example(
    troubles=[(Failure.UNPLUGGED, 57), (Failure.STUCK, 196)]
)  # deaf while it was set up: slow afterwards
def test_after_any_row_of_failures_it_comes_back(name: str, troubles: list[tuple[Failure, int]]) -> None:
    made = Rig(name)
    try:
        made.driver.start()
        for failure, cycles in troubles:
            made.device.inject(failure)
            made.cycles(1.0, cycles)
        made.device.inject(Failure.NONE)
        assert made.cycles(1.5, 1600)[-1] == pytest.approx(1.5, abs=SLOWEST_M_S2)
    finally:
        made.close()


@EVERY
def test_frames_that_come_in_bursts_give_the_newest(rig: Callable[..., Rig], name: str) -> None:
    made = rig(name)
    made.cycles(0.0, 20)
    made.device.inject(Failure.LATE)
    fresh = 0
    for step in range(600):
        (value,) = made.cycles(0.01 * step, 1)
        if made.driver.last_reading().status == SampleStatus.FRESH:
            fresh += 1
            behind = round(1000.0 / SERIAL_DEVICES[name].rate_hz)
            assert value == pytest.approx(0.01 * step, abs=0.01 * behind + SLOWEST_M_S2)
    assert 600 * SERIAL_DEVICES[name].rate_hz / 1000.0 / 20.0 == pytest.approx(fresh, abs=2)


@EVERY
def test_a_sample_stands_for_a_while_and_then_no_more(rig: Callable[..., Rig], name: str) -> None:
    made = rig(name)
    made.cycles(1.0, 20)
    stands_s = max(0.006, 3.0 / SERIAL_DEVICES[name].rate_hz)
    made.now_s = made.driver._arrived_s + stands_s - 1e-4
    assert made.driver.read() == pytest.approx(1.0, abs=SLOWEST_M_S2)
    assert made.driver.last_reading().status == SampleStatus.HELD
    made.now_s += 2e-4
    assert isnan(made.driver.read())
    assert made.driver.last_reading().status == SampleStatus.STALE


@EVERY
def test_a_read_takes_at_most_a_kilobyte(rig: Callable[..., Rig], name: str) -> None:
    """Also with a long backlog, of which it reads the newest part."""
    made = rig(name)
    for step in range(3000):
        made.feel(0.001 * step)
    frames = made.driver._decoder.frames
    for _ in range(10):
        before = made.driver._decoder.frames
        made.driver.read()
        assert made.driver._decoder.frames - before <= 1024 // 11 + 1
    assert made.driver._decoder.frames > frames


@EVERY
def test_another_device_is_refused(rig: Callable[..., Rig], name: str) -> None:
    made = rig(name, start=False)
    made.device.inject(Failure.WRONG_IDENTITY)
    with pytest.raises(
        UserError, match=r"^accelerometer\.port = [^\n]*no frame of[^\n]*accelerometer\.driver[^\n]*$"
    ):
        made.driver.start()
    with pytest.raises(RuntimeError, match="start"):
        made.driver.read()


@EVERY
def test_a_silent_device_is_refused(rig: Callable[..., Rig], name: str) -> None:
    made = rig(name, start=False)
    made.device.inject(Failure.STUCK)
    with pytest.raises(UserError, match=r"^accelerometer\.port = [^\n]*gives no samples[^\n]*$"):
        made.driver.start()


def test_a_port_that_is_not_there_is_told() -> None:
    for port in ("pty:nobody-made-it", "/dev/no-such-port"):
        config = AccelerometerDevice(driver="xsens", port=port)
        driver = SerialAccelerometer(config, SERIAL_DEVICES["xsens"], wait_s=0.0)
        with pytest.raises(UserError, match=r"^accelerometer\.port = [^\n]*$"):
            driver.start()


def test_the_microcontroller_tells_range_rate_and_delay(rig: Callable[..., Rig]) -> None:
    made = rig("microcontroller")
    made.cycles(0.0, 600)
    assert made.driver.rate_hz == 1000.0
    assert made.driver.range_m_s2 == pytest.approx(39.2)
    assert made.driver.delay_s == pytest.approx(SERIAL_DEVICES["microcontroller"].delay_s)
    assert made.cycles(100.0, 5)[-1] == pytest.approx(39.2)
    assert made.driver.last_reading().device_status & 0x02  # clipped


def test_the_port_disappears_with_the_device(rig: Callable[..., Rig]) -> None:
    made = rig("xsens")
    assert Path(port_path(PORT)).exists()
    made.device.inject(Failure.UNPLUGGED)
    assert not Path(port_path(PORT)).exists()
    assert isnan(made.cycles(0.0, 1)[0])
    assert made.driver.last_reading().status == SampleStatus.NO_ANSWER
