"""Block reads through each part's FIFO: every sample once, in order, and what an overrun leaves."""

import os
from collections.abc import Callable, Iterator
from itertools import pairwise

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.accelerometers.accelerometer import SampleStatus
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.buses.parts import SENSED_PARTS
from stillarm.drivers.emulated_chips.shared_registers import SensedRegisters

NAME = f"test-i2c-fifo-{os.getpid()}"
PARTS = [part for part in sorted(TABLES) if TABLES[part].fifo is not None]
Felt = Callable[[int], None]
# The value of sample n on x; its half on z. Coarse enough for the coarsest part, and below 2 g.
STEP_M_S2 = 0.09


@pytest.fixture
def pair(part: str) -> Iterator[tuple[I2cAccelerometer, Felt]]:
    registers = SensedRegisters(NAME, SENSED_PARTS[part])
    config = AccelerometerDevice(driver=part, bus=f"memory:{NAME}", axis="x")  # type: ignore[arg-type]
    driver = I2cAccelerometer(config, TABLES[part], wait_s=0.0)
    driver.start()

    def feel(n: int) -> None:
        registers.publish((STEP_M_S2 * n, 1.0, STEP_M_S2 * n / 2))

    yield driver, feel
    driver.close()
    registers.close()


def numbers(block: list[tuple[float, float, float]]) -> list[int]:
    """Which samples these are; axes that do not belong together fail."""
    for x, y, z in block:
        assert y == pytest.approx(1.0, abs=0.04)
        assert z == pytest.approx(x / 2, abs=0.06)
    return [round(x / STEP_M_S2) for x, _, _ in block]


@pytest.mark.parametrize("part", PARTS)
def test_every_sample_comes_once_and_in_order(part: str, pair: tuple[I2cAccelerometer, Felt]) -> None:
    driver, feel = pair
    driver.start_blocks()
    assert driver.read_block() == []
    seen: list[int] = []
    sent = 0
    for length in (1, 7, 30, 2, 20, 0, 25):
        for _ in range(length):
            sent += 1
            feel(sent)
        seen += numbers(driver.read_block())
    expected = list(range(1, sent + 1))
    rate_hz = TABLES[part].filters[0].rate_hz
    if rate_hz < 1000.0:  # of 1000 felt a second
        assert len(seen) == pytest.approx(1e-3 * rate_hz * sent, abs=2)
        assert seen == sorted(set(seen))
    else:
        assert seen == expected


@pytest.mark.parametrize("part", PARTS)
def test_an_overrun_leaves_the_newest(part: str, pair: tuple[I2cAccelerometer, Felt]) -> None:
    driver, feel = pair
    fifo = TABLES[part].fifo
    assert fifo is not None
    driver.start_blocks()
    for n in range(400):
        feel(n % 200)
    seen = numbers(driver.read_block())
    assert len(seen) == fifo.depth
    assert seen[-1] == 199 or TABLES[part].filters[0].rate_hz < 1000.0
    assert all(0 < b - a <= 2 for a, b in pairwise(seen))


@pytest.mark.parametrize("part", PARTS)
def test_after_blocks_single_reads_go_on(part: str, pair: tuple[I2cAccelerometer, Felt]) -> None:
    driver, feel = pair
    driver.start_blocks()
    for n in range(10):
        feel(n)
    driver.read_block()
    driver.stop_blocks()
    for _ in range(3):
        feel(50)
        value = driver.read()
    assert value == pytest.approx(50 * STEP_M_S2, abs=0.04)
    assert driver.last_reading().status in (SampleStatus.FRESH, SampleStatus.HELD)


@pytest.mark.parametrize("part", ["lis3lv02dq"])
def test_a_part_without_one_says_so(part: str, pair: tuple[I2cAccelerometer, Felt]) -> None:
    driver, _ = pair
    with pytest.raises(UserError, match="LIS3LV02DQ has no FIFO"):
        driver.start_blocks()
