"""The bus's speed, and reads that gave no sample."""

from collections.abc import Callable
from math import nan

import pytest

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.files.model import Model
from stillarm.drivers.accelerometers.accelerometer import Reading, SampleStatus
from stillarm.preflight.sensor import SensorFacts, judge_bus, judge_pause, judge_sensor, read_sensor
from stillarm.preflight.verdict import Level

CYCLE_S = 0.001


@pytest.mark.parametrize(
    ("declared", "level"), [(100_000.0, Level.FAIL), (400_000.0, Level.OK), (1e6, Level.OK)]
)
def test_what_the_device_tree_says_of_the_bus_is_believed(declared: float, level: Level) -> None:
    assert judge_bus("/dev/i2c-1", declared, 0.0003, CYCLE_S).level == level


class Accelerometer:
    """One at rest that gives no sample at some reads."""

    rate_hz = 1000.0
    faults = 0

    def __init__(self, lacks: Callable[[int], bool]) -> None:
        self._lacks, self._reads = lacks, 0

    def read(self) -> float:
        self._reads += 1
        return 0.0

    def last_reading(self) -> Reading:
        up = 9.80665 + 0.5 * (-1) ** self._reads
        status = SampleStatus.STALE if self._lacks(self._reads) else SampleStatus.FRESH
        return Reading((0.0, 0.5 * (-1) ** self._reads, up), status, -1, 0.0, nan)

    def identify(self) -> str:
        return "one of the tests' own"


def look(lacks: Callable[[int], bool]) -> SensorFacts:
    now = [0.0]

    def sleep(seconds: float) -> None:
        now[0] += max(seconds, 1e-6)

    return read_sensor(Accelerometer(lacks), CYCLE_S, 0.6, clock=lambda: now[0], sleep=sleep)


@pytest.mark.parametrize(
    ("lacks", "pause"),
    [
        (lambda read: False, False),
        (lambda read: 100 < read <= 119, True),  # 19 in a row
        (lambda read: read % 30 == 0, False),  # 20 here and there: the wire
        (lambda read: 100 < read <= 105, False),  # too few to be a fault
    ],
)
def test_reads_that_fail_in_one_row_are_told_from_a_bad_wire(
    lacks: Callable[[int], bool], pause: bool
) -> None:
    found = judge_pause(look(lacks))
    assert (found is not None) is pause
    if found is not None:
        assert found.level == Level.WARN and "19 reads in a row" in found.text


def test_reads_that_fail_here_and_there_stay_a_fault() -> None:
    verdicts = judge_sensor(look(lambda read: read % 30 == 0), AccelerometerDevice(), Model())
    assert any(one.level == Level.FAIL and "check wiring" in one.text for one in verdicts)
