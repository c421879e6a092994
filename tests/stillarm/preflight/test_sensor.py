"""The bus's speed."""

import pytest

from stillarm.preflight.sensor import judge_bus
from stillarm.preflight.verdict import Level

CYCLE_S = 0.001


@pytest.mark.parametrize(
    ("declared", "level"), [(100_000.0, Level.FAIL), (400_000.0, Level.OK), (1e6, Level.OK)]
)
def test_what_the_device_tree_says_of_the_bus_is_believed(declared: float, level: Level) -> None:
    assert judge_bus("/dev/i2c-1", declared, 0.0003, CYCLE_S).level == level
