"""What is freed goes back to the system, whatever was freed before."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SCRIPT = """
import sys
import numpy as np
from stillarm.common.memory.returned_memory import return_freed_memory

def resident_mb():
    return int(open("/proc/self/statm").read().split()[1]) * 4096 / 2**20

able = return_freed_memory() if sys.argv[1] == "on" else None
np.ones(3 << 20)  # 24 MiB, freed at once: from now on smaller arrays would lie in the heap
before = resident_mb()
arrays = [np.ones(1 << 16) for _ in range(200)]  # 100 MiB
last = np.ones(100)
del arrays[:-1]
print(able, resident_mb() - before)
"""


def left_mb(switch: str) -> tuple[str, float]:
    words = [sys.executable, "-c", SCRIPT, switch]
    said = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    return said[0], float(said[1])


@pytest.mark.slow
def test_half_a_megabyte_that_is_freed_is_given_back() -> None:
    able, left = left_mb("on")
    if able == "True":
        assert left < 10.0
    assert left <= left_mb("off")[1] + 5.0
