"""The driver of the I2C accelerometers on emulated registers: every part, every range, every failure."""

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator
from math import isnan, sqrt
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.memory.shared_memory import block_path
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer import SampleStatus
from stillarm.drivers.accelerometers.accelerometer_factory import open_accelerometer
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.buses.i2c import open_bus
from stillarm.drivers.buses.parts import SENSED_PARTS
from stillarm.drivers.emulated_chips.shared_registers import LATE_S, Failure, SensedRegisters
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

NAME = f"test-i2c-accelerometer-{os.getpid()}"
BUS = f"memory:{NAME}"
PARTS = sorted(TABLES)
# Emulators do not know the tables: a count of each part at +-2 g, after its data sheet, in m/s^2.
COUNT_M_S2 = {
    "lis3lv02dq": 9.80665 / 1024,
    "lis3dh": 9.80665 / 1000,
    "adxl345": 9.80665 / 256,
    "adxl355": 9.80665 / 256000,
    "mpu6050": 9.80665 / 16384,
    "icm20948": 9.80665 / 16384,
}


class Rig:
    """Registers, driver and a clock that moves by a cycle with every sample felt."""

    def __init__(self, part: str, **config: Any) -> None:
        self.part = part
        self.config = AccelerometerDevice(driver=part, bus=BUS, **config)  # type: ignore[arg-type]
        self.registers = SensedRegisters(NAME, SENSED_PARTS[part])
        self.now_s = 1000.0
        self.driver = I2cAccelerometer(
            self.config, TABLES[part], wait_s=0.0, sleep=self.sleep, clock=lambda: self.now_s
        )

    def sleep(self, duration_s: float) -> None:
        self.now_s += duration_s

    def feel(self, acceleration_m_s2: float) -> None:
        self.now_s += 0.001
        self.registers.publish(sensed_axes(acceleration_m_s2, self.config))

    def cycles(self, acceleration_m_s2: float, count: int) -> list[float]:
        seen = []
        for _ in range(count):
            self.feel(acceleration_m_s2)
            seen.append(self.driver.read())
        return seen

    def close(self) -> None:
        self.driver.close()
        self.registers.close()


@pytest.fixture
def rig() -> Iterator[Callable[..., Rig]]:
    made: list[Rig] = []

    def make(part: str, *, start: bool = True, **config: Any) -> Rig:
        made.append(Rig(part, **config))
        if start:
            made[-1].driver.start()
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_reads_each_axis_and_gravity_only_where_it_is(rig: Callable[..., Rig], part: str, axis: str) -> None:
    made = rig(part, axis=axis)
    count = COUNT_M_S2[part]
    assert made.cycles(3.2, 5)[-1] == pytest.approx(3.2, abs=count)
    made.cycles(-7.7, 5)
    assert made.driver.read() == pytest.approx(-7.7, abs=count)
    xyz = made.driver.last_reading().acceleration_xyz_m_s2
    gravity = "y" if axis == "z" else "z"
    assert xyz["xyz".index(gravity)] == pytest.approx(STANDARD_GRAVITY_M_S2, abs=count)
    assert sum(abs(value) < count for value in xyz) == 1


@pytest.mark.parametrize(
    ("part", "full_scale_g"), [(part, g) for part in PARTS for g in TABLES[part].full_scales]
)
def test_every_range_clips_where_it_ends(rig: Callable[..., Rig], part: str, full_scale_g: int) -> None:
    made = rig(part, full_scale_g=full_scale_g)
    at = 0.9 * full_scale_g * STANDARD_GRAVITY_M_S2
    step = made.driver.range_m_s2 / TABLES[part].full_scales[full_scale_g].max_count * 64
    assert made.cycles(at, 5)[-1] == pytest.approx(at, abs=step)
    limit = made.cycles(1e4, 5)[-1]
    assert limit == pytest.approx(made.driver.range_m_s2, rel=0.01)
    assert made.driver.range_m_s2 >= 0.95 * full_scale_g * STANDARD_GRAVITY_M_S2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "bandwidth_hz"), [(p, f.bandwidth_hz) for p in PARTS for f in TABLES[p].filters]
)
def test_every_filter_gives_its_rate_and_tells_its_delay(
    rig: Callable[..., Rig], part: str, bandwidth_hz: float
) -> None:
    made = rig(part, bandwidth_hz=bandwidth_hz)
    chosen = next(f for f in TABLES[part].filters if f.bandwidth_hz == bandwidth_hz)
    assert (made.driver.delay_s, made.driver.rate_hz) == (chosen.delay_s, chosen.rate_hz)
    fresh = 0
    for _ in range(1000):
        made.feel(1.0)
        made.driver.read()
        fresh += made.driver.last_reading().status == SampleStatus.FRESH
    assert fresh == pytest.approx(min(chosen.rate_hz, 1000.0), abs=1)


@pytest.mark.parametrize("part", PARTS)
def test_sign_rotation_and_bias(rig: Callable[..., Rig], part: str) -> None:
    made = rig(part, axis="y", sign=-1, rotation_deg=(20.0, -35.0, 50.0), bias_m_s2=0.25)
    count = COUNT_M_S2[part]
    assert made.cycles(3.0, 5)[-1] == pytest.approx(3.0 - 0.25, abs=2 * count)
    xyz = made.driver.last_reading().acceleration_xyz_m_s2
    felt = sqrt(3.0**2 + STANDARD_GRAVITY_M_S2**2)
    assert sqrt(sum(value**2 for value in xyz)) == pytest.approx(felt, abs=2 * count)


@pytest.mark.parametrize("part", PARTS)
def test_the_last_sample_stands_for_five_reads_and_not_for_the_sixth(
    rig: Callable[..., Rig], part: str
) -> None:
    made = rig(part)
    first = made.cycles(1.0, 3)[-1]
    assert [made.driver.read() for _ in range(5)] == [first] * 5
    assert made.driver.last_reading().status == SampleStatus.HELD
    assert made.driver.faults == 0
    assert isnan(made.driver.read())
    assert made.driver.last_reading().status == SampleStatus.STALE
    assert made.driver.faults == 1
    assert made.cycles(2.0, 2)[-1] == pytest.approx(2.0, abs=COUNT_M_S2[part])


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("failure", [Failure.NAK, Failure.STUCK, Failure.UNPLUGGED])
def test_a_device_that_went_away_comes_back_by_itself(
    rig: Callable[..., Rig], part: str, failure: Failure
) -> None:
    made = rig(part)
    assert made.cycles(1.0, 3)[-1] == pytest.approx(1.0, abs=COUNT_M_S2[part])
    made.registers.inject(failure)
    away = made.cycles(2.0, 300)
    assert all(isnan(value) for value in away[6:])
    made.registers.inject(Failure.NONE)
    back = made.cycles(3.0, 200)
    there = [not isnan(value) for value in back]
    assert there.index(True) < 150
    assert back[-1] == pytest.approx(3.0, abs=COUNT_M_S2[part])


@pytest.mark.parametrize("part", PARTS)
def test_a_read_never_makes_more_than_one_transfer(
    rig: Callable[..., Rig], part: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For any failure of the device: the loop's time for it is bounded."""
    made = rig(part)
    bus, transfers = made.driver._bus, []
    assert bus is not None
    whole, byte = type(bus).i2c_rdwr, type(bus).write_byte_data

    def counted(call: Any) -> Any:
        return lambda *arguments: (transfers.append(1), call(*arguments))[1]

    monkeypatch.setattr(type(bus), "i2c_rdwr", counted(whole))
    monkeypatch.setattr(type(bus), "write_byte_data", counted(byte))
    for failure in Failure:
        if failure == Failure.LATE:
            continue
        made.registers.inject(failure)
        for _ in range(120):
            before = len(transfers)
            made.feel(1.0)
            made.driver.read()
            assert len(transfers) - before <= 1


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
@settings(max_examples=15, deadline=None)
@given(
    troubles=st.lists(
        st.tuples(st.sampled_from([f for f in Failure if f != Failure.LATE]), st.integers(1, 120)), max_size=6
    )
)
def test_after_any_row_of_failures_it_comes_back(part: str, troubles: list[tuple[Failure, int]]) -> None:
    made = Rig(part)
    try:
        made.driver.start()
        for failure, cycles in troubles:
            made.registers.inject(failure)
            for value in made.cycles(1.0, cycles):
                assert isnan(value) or abs(value) <= made.driver.range_m_s2
        made.registers.inject(Failure.NONE)
        assert made.cycles(1.5, 250)[-1] == pytest.approx(1.5, abs=COUNT_M_S2[part])
    finally:
        made.close()


@pytest.mark.parametrize("part", PARTS)
def test_garbage_never_leaves_the_range(rig: Callable[..., Rig], part: str) -> None:
    made = rig(part)
    made.registers.inject(Failure.GARBAGE)
    seen = made.cycles(1.0, 300)
    assert all(isnan(value) or abs(value) <= made.driver.range_m_s2 for value in seen)
    made.registers.inject(Failure.NONE)
    assert made.cycles(1.5, 200)[-1] == pytest.approx(1.5, abs=COUNT_M_S2[part])


@pytest.mark.slow
@pytest.mark.parametrize("part", ["lis3lv02dq", "adxl355"])
def test_a_bus_that_is_late_takes_a_twentieth_of_the_time(rig: Callable[..., Rig], part: str) -> None:
    made = rig(part)
    made.registers.inject(Failure.LATE)
    made.now_s = time.monotonic()
    made.driver._clock = time.monotonic
    started = time.monotonic()
    reads = 0
    while time.monotonic() - started < 0.3:
        made.driver.read()
        reads += 1
    # At most one transfer in 20 times its length: had every read waited, there would have been 100 reads.
    assert reads > 0.3 / LATE_S * 2


def test_a_delay_of_the_process_is_not_taken_for_the_bus_s(rig: Callable[..., Rig]) -> None:
    """Twice late, then in time: no read is left out."""
    made = rig("lis3dh")
    made.cycles(1.0, 3)
    delays = iter([0.005, 0.005, 0.0, 0.005, 0.005, 0.0])
    started = iter([True, False] * 6)
    here = made.now_s

    def clock() -> float:
        nonlocal here
        here += 0.001 if next(started) else next(delays)
        return here

    made.driver._clock = clock
    for _ in range(6):
        made.feel(2.0)
        assert made.driver.read() == pytest.approx(2.0, abs=COUNT_M_S2["lis3dh"])


def test_a_device_that_lost_its_power_is_set_up_again(rig: Callable[..., Rig]) -> None:
    made = rig("lis3lv02dq")
    made.cycles(1.0, 1)
    with open_bus(BUS) as bus:
        bus.write_byte_data(0x1D, 0x20, 0x07)  # as after power-up: powered down
    seen = made.cycles(2.0, 100)
    assert isnan(seen[40])
    assert seen[-1] == pytest.approx(2.0, abs=COUNT_M_S2["lis3lv02dq"])


@pytest.mark.parametrize("part", PARTS)
def test_a_rig_that_restarts_is_found_again(rig: Callable[..., Rig], part: str) -> None:
    made = rig(part)
    made.cycles(1.0, 3)
    made.registers.close()
    made.registers = SensedRegisters(NAME, SENSED_PARTS[part])
    seen = made.cycles(2.0, 1500)
    assert isnan(seen[100])
    assert seen[-1] == pytest.approx(2.0, abs=COUNT_M_S2[part])


@pytest.mark.parametrize("part", PARTS)
def test_another_identity_is_refused(rig: Callable[..., Rig], part: str) -> None:
    made = rig(part, start=False)
    made.registers.inject(Failure.WRONG_IDENTITY)
    with pytest.raises(UserError) as caught:
        made.driver.start()
    text = str(caught.value)
    assert "\n" not in text
    for word in (BUS, TABLES[part].name, TABLES[part].identity.hex(), "accelerometer.driver"):
        assert word in text


@pytest.mark.parametrize("part", PARTS)
def test_identify(rig: Callable[..., Rig], part: str) -> None:
    made = rig(part)
    assert made.driver.identify().startswith(f"{TABLES[part].name} at 0x")


@pytest.mark.parametrize("failure", ["nak", "address"])
@pytest.mark.parametrize("part", PARTS)
def test_a_device_that_does_not_answer_is_refused(rig: Callable[..., Rig], part: str, failure: str) -> None:
    made = rig(part, start=False, address=0 if failure == "nak" else 0x33)
    if failure == "nak":
        made.registers.inject(Failure.NAK)
    with pytest.raises(
        UserError, match=r"^accelerometer\.bus = [^\n]*no [^\n]* answers[^\n]*i2cdetect[^\n]*$"
    ):
        made.driver.start()
    with pytest.raises(RuntimeError, match="start"):
        made.driver.read()


@pytest.mark.parametrize(
    ("part", "config", "words"),
    [
        ("lis3dh", {"full_scale_g": 6}, ["accelerometer.full_scale_g = 6", "2 or 4 or 8 or 16"]),
        ("adxl355", {"full_scale_g": 16}, ["accelerometer.full_scale_g = 16", "2 or 4 or 8"]),
        ("mpu6050", {"bandwidth_hz": 100.0}, ["accelerometer.bandwidth_hz = 100", "184 or 260 or 94 or 44"]),
        ("adxl345", {"address": 2}, ["accelerometer.address = 2", "0x53 or 0x1d"]),
    ],
)
def test_settings_that_a_part_does_not_have(part: str, config: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(UserError) as caught:
        open_accelerometer(AccelerometerDevice(driver=part, **config))  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_a_device_without_samples_is_refused_where_time_passes() -> None:
    registers = SensedRegisters(NAME, SENSED_PARTS["lis3lv02dq"])
    waits: list[float] = []
    driver = I2cAccelerometer(
        AccelerometerDevice(bus=BUS), TABLES["lis3lv02dq"], wait_s=1.0, sleep=waits.append
    )
    with pytest.raises(UserError, match=r"^accelerometer\.bus = [^\n]*gives no samples[^\n]*$"):
        driver.start()
    assert sum(waits) > 0.9
    registers.close()


def test_start_waits_for_the_first_sample() -> None:
    registers = SensedRegisters(NAME, SENSED_PARTS["lis3lv02dq"])
    naps: list[float] = []

    def sleep(duration_s: float) -> None:
        naps.append(duration_s)
        if len(naps) == 10:
            registers.publish((0.0, 1.0, STANDARD_GRAVITY_M_S2))

    clock = iter(range(1_000_000))
    driver = I2cAccelerometer(
        AccelerometerDevice(bus=BUS),
        TABLES["lis3lv02dq"],
        wait_s=1.0,
        sleep=sleep,
        clock=lambda: 1e-4 * next(clock),
    )
    driver.start()
    assert driver.faults == 0
    assert len(naps) == 10
    assert driver.read() == pytest.approx(1.0, abs=COUNT_M_S2["lis3lv02dq"])
    driver.close()
    driver.close()
    registers.close()


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
@settings(max_examples=100, deadline=None)
@given(answers=st.lists(st.binary(min_size=13, max_size=13), min_size=1, max_size=4))
def test_no_bytes_make_a_read_raise_or_leave_the_range(part: str, answers: list[bytes]) -> None:
    driver = I2cAccelerometer(AccelerometerDevice(driver=part), TABLES[part], wait_s=0.0)  # type: ignore[arg-type]
    answer = driver._transfer._buffer

    class Bus:
        def i2c_rdwr(self, *_: Any) -> None:
            answer.raw = answers[reads][: len(answer)]

        def write_byte_data(self, *_: int) -> None: ...

        def close(self) -> None: ...

    driver._bus = Bus()
    for reads in range(len(answers)):  # noqa: B007 - the bus counts by it
        value = driver.read()
        assert isnan(value) or abs(value) <= driver.range_m_s2
    driver.close()


def _publish(name: str, ready: Any, stop: Any) -> None:
    registers = SensedRegisters(name, SENSED_PARTS["adxl355"])
    ready.set()
    step = 0
    while not stop.is_set():
        step = (step + 1) % 1000
        value = step * 0.01
        registers.publish((value, value, value))
    registers.close()


@pytest.mark.slow
def test_samples_from_another_process_are_never_torn() -> None:
    name = f"{NAME}-other"
    context = multiprocessing.get_context("spawn")
    ready, stop = context.Event(), context.Event()
    process = context.Process(target=_publish, args=(name, ready, stop), daemon=True)
    process.start()
    try:
        assert ready.wait(120.0)
        config = AccelerometerDevice(driver="adxl355", bus=f"memory:{name}")
        driver = I2cAccelerometer(config, TABLES["adxl355"], wait_s=10.0)
        driver.start()
        values: set[int] = set()
        give_up = time.monotonic() + 120.0  # the two may share one processor
        while len(values) < 200 and time.monotonic() < give_up:
            driver.read()
            x, y, z = driver._counts
            assert x == y == z
            values.add(x)
            time.sleep(1e-5)
        assert len(values) >= 200
        driver.close()
    finally:
        stop.set()
        process.join(30.0)
    assert process.exitcode == 0
    assert not block_path(name).exists()
