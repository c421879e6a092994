"""The accelerometer's driver and its emulator, through smbus2's own code."""

import multiprocessing
import os
import time
from collections.abc import Iterator
from math import isnan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.configuration import AccelerometerDevice
from common.shared_memory import block_path
from common.user_error import UserError
from drivers.accelerometer_factory import open_accelerometer
from drivers.emulation.lis3lv02dq_registers import (
    STANDARD_GRAVITY_M_S2,
    Failure,
    Lis3lv02dqRegisters,
    sensed_axes,
)
from drivers.i2c import open_bus
from drivers.lis3lv02dq import Lis3lv02dq

NAME = f"test-lis3lv02dq-{os.getpid()}"
BUS = f"memory:{NAME}"
ADDRESS = 0x1D
COUNT_M_S2 = STANDARD_GRAVITY_M_S2 / 1024.0


@pytest.fixture
def registers() -> Iterator[Lis3lv02dqRegisters]:
    made = Lis3lv02dqRegisters(NAME)
    yield made
    made.close()


def started(**config: Any) -> Lis3lv02dq:
    driver = Lis3lv02dq(AccelerometerDevice(bus=BUS, **config), wait_s=0.0)
    driver.start()
    return driver


def feel(registers: Lis3lv02dqRegisters, acceleration: float, axis: Any = "y") -> None:
    registers.publish(sensed_axes(acceleration, axis))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_reads_each_axis_and_gravity_only_where_it_is(registers: Lis3lv02dqRegisters, axis: Any) -> None:
    driver = started(axis=axis)
    for value in (3.0, -3.0, 0.0, 19.0):
        feel(registers, value, axis)
        assert driver.read() == pytest.approx(value, abs=COUNT_M_S2 / 2.0)
    driver.close()
    still = []
    for other in "xyz".replace(axis, ""):
        driver = started(axis=other)
        feel(registers, 3.0, axis)
        still.append(round(driver.read(), 2))
        driver.close()
    assert sorted(still) == [0.0, 9.81]


@pytest.mark.parametrize(("full_scale_g", "limit"), [(2, 2047 / 1024), (6, 2047 / 340)])
def test_clips_at_the_range_that_was_set(
    registers: Lis3lv02dqRegisters, full_scale_g: Any, limit: float
) -> None:
    driver = started(full_scale_g=full_scale_g)
    feel(registers, 100.0)
    assert driver.read() == pytest.approx(limit * STANDARD_GRAVITY_M_S2, rel=1e-12)
    feel(registers, 15.0)
    assert driver.read() == pytest.approx(
        15.0, abs=STANDARD_GRAVITY_M_S2 / {2: 1024, 6: 340}[full_scale_g] / 2.0
    )
    driver.close()


def test_the_last_sample_stands_for_five_reads_and_not_for_the_sixth(registers: Lis3lv02dqRegisters) -> None:
    driver = started()
    feel(registers, 1.0)
    fresh = driver.read()
    assert [driver.read() for _ in range(5)] == [fresh] * 5
    assert driver.faults == 0
    assert isnan(driver.read())
    assert driver.faults == 1
    feel(registers, 2.0)
    assert driver.read() == pytest.approx(2.0, abs=COUNT_M_S2)
    driver.close()


def test_before_the_first_sample_there_is_none(registers: Lis3lv02dqRegisters) -> None:
    driver = started()
    assert isnan(driver.read())
    driver.close()


@pytest.mark.parametrize("failure", [Failure.NAK, Failure.GARBAGE])
def test_a_fault_of_the_bus_is_a_missing_sample_and_passes(
    registers: Lis3lv02dqRegisters, failure: Failure
) -> None:
    driver = started()
    feel(registers, 1.0)
    assert driver.read() > 0.9
    registers.inject(failure)
    for _ in range(100):
        feel(registers, 1.0)
        assert isnan(driver.read())
    assert driver.faults == 100
    registers.inject(Failure.NONE)
    feel(registers, 1.0)
    assert driver.read() > 0.9
    driver.close()


def test_a_stuck_device_runs_stale(registers: Lis3lv02dqRegisters) -> None:
    driver = started()
    feel(registers, 1.0)
    driver.read()
    registers.inject(Failure.STUCK)
    seen = []
    for _ in range(20):
        feel(registers, 2.0)
        seen.append(driver.read())
    assert not any(isnan(value) for value in seen[:5])
    assert all(isnan(value) for value in seen[5:])
    assert driver.faults == 15
    driver.close()


def test_a_device_that_lost_its_power_is_set_up_again(registers: Lis3lv02dqRegisters) -> None:
    driver = started()
    feel(registers, 1.0)
    driver.read()
    with open_bus(BUS) as bus:
        bus.write_byte_data(ADDRESS, 0x20, 0x07)  # as after power-up: powered down
    seen = []
    for _ in range(600):
        feel(registers, 2.0)
        seen.append(driver.read())
    assert isnan(seen[490])
    assert seen[-1] == pytest.approx(2.0, abs=COUNT_M_S2)
    driver.close()


def test_a_rig_that_restarts_is_found_again() -> None:
    first = Lis3lv02dqRegisters(NAME)
    driver = started()
    feel(first, 1.0)
    driver.read()
    first.close()
    second = Lis3lv02dqRegisters(NAME)
    seen = []
    for _ in range(1100):
        feel(second, 2.0)
        seen.append(driver.read())
    assert isnan(seen[100])
    assert seen[-1] == pytest.approx(2.0, abs=COUNT_M_S2)
    driver.close()
    second.close()


def test_another_identity_is_refused(registers: Lis3lv02dqRegisters) -> None:
    registers.inject(Failure.WRONG_IDENTITY)
    with pytest.raises(UserError) as caught:
        started()
    text = str(caught.value)
    assert "\n" not in text
    for part in (BUS, "0x1d", "0xc5", "0x3a", "accelerometer.driver"):
        assert part in text


@pytest.mark.parametrize("failure", ["nak", "address"])
def test_a_device_that_does_not_answer_is_refused(registers: Lis3lv02dqRegisters, failure: str) -> None:
    if failure == "nak":
        registers.inject(Failure.NAK)
    config = AccelerometerDevice(bus=BUS, address=ADDRESS if failure == "nak" else 0x1C)
    driver = Lis3lv02dq(config, wait_s=0.0)
    with pytest.raises(
        UserError, match=r"^accelerometer\.bus = [^\n]*no LIS3LV02DQ answers[^\n]*i2cdetect[^\n]*$"
    ):
        driver.start()
    with pytest.raises(RuntimeError, match="start"):
        driver.read()


def test_a_device_without_samples_is_refused_where_time_passes(registers: Lis3lv02dqRegisters) -> None:
    waits: list[float] = []
    driver = Lis3lv02dq(AccelerometerDevice(bus=BUS), wait_s=1.0, sleep=waits.append)
    with pytest.raises(UserError, match=r"^accelerometer\.bus = [^\n]*gives no samples[^\n]*$"):
        driver.start()
    assert 0.9 < sum(waits) < 1.1
    assert waits[0] >= 5.0 / 2560.0


def test_start_waits_for_the_first_sample(registers: Lis3lv02dqRegisters) -> None:
    naps: list[float] = []

    def sleep(duration_s: float) -> None:
        naps.append(duration_s)
        if len(naps) == 10:
            feel(registers, 1.0)

    driver = Lis3lv02dq(AccelerometerDevice(bus=BUS), wait_s=1.0, sleep=sleep)
    driver.start()
    assert len(naps) == 10
    assert driver.faults == 0
    assert driver.read() == pytest.approx(1.0, abs=COUNT_M_S2)
    driver.close()
    driver.close()


def test_factory(registers: Lis3lv02dqRegisters) -> None:
    assert open_accelerometer(AccelerometerDevice(driver="none")) is None
    driver = open_accelerometer(AccelerometerDevice(bus=BUS), wait_s=0.0)
    assert driver is not None
    driver.start()
    assert 0.0 < driver.delay_s < 0.001
    driver.close()


@settings(max_examples=100, deadline=None)
@given(st.binary(min_size=7, max_size=7))
def test_no_bytes_make_a_read_raise_or_leave_the_range(data: bytes) -> None:
    driver = Lis3lv02dq(AccelerometerDevice(bus=BUS), wait_s=0.0)

    class Bus:
        def i2c_rdwr(self, request: Any, answer: Any) -> None:
            driver._data.raw = data

        def write_byte_data(self, *_: int) -> None: ...

        def close(self) -> None: ...

    driver._bus = Bus()
    value = driver.read()
    assert isnan(value) or abs(value) <= 2.0 * STANDARD_GRAVITY_M_S2
    driver.close()


def _publish(name: str, ready: Any, stop: Any) -> None:
    registers = Lis3lv02dqRegisters(name)
    ready.set()
    step = 0
    while not stop.is_set():
        step = (step + 1) % 1000
        value = step * COUNT_M_S2
        registers.publish((value, value, value))
    registers.close()


def test_samples_from_another_process_are_never_torn() -> None:
    name = f"{NAME}-other"
    context = multiprocessing.get_context("spawn")
    ready, stop = context.Event(), context.Event()
    process = context.Process(target=_publish, args=(name, ready, stop), daemon=True)
    process.start()
    try:
        assert ready.wait(30.0)
        driver = Lis3lv02dq(AccelerometerDevice(bus=f"memory:{name}"), wait_s=10.0)
        driver.start()
        values: set[int] = set()
        give_up = time.monotonic() + 30.0  # the two may share one processor
        while len(values) < 200 and time.monotonic() < give_up:
            driver.read()
            _, x, y, z = driver._table.layout.unpack_from(driver._data)
            assert x == y == z
            values.add(x)
            time.sleep(1e-5)
        assert len(values) == 200
        driver.close()
    finally:
        stop.set()
        process.join(30.0)
    assert process.exitcode == 0
    assert not block_path(name).exists()
