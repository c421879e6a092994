"""cyclictest's histogram."""

import pytest

from stillarm.benchmarks.loop import cyclictest
from stillarm.benchmarks.loop.slices import Measured

# as cyclictest 2.4 prints it
HISTOGRAM = """# /dev/cpu_dma_latency set to 0us
# Histogram
000000 000000
000003 000090
000012 000009
002500 000001
# Total: 000000100
# Min Latencies: 00003
# Histogram Overflows: 00002
# Histogram Overflow at cycle number:
# Thread 0: 00120
"""


def test_cyclictest_histogram_is_taken_in() -> None:
    """Counts, what lies beyond the histogram, and cycles wholly passed as missed."""
    measured = Measured()
    cyclictest.add_histogram(HISTOGRAM, measured, 0.001)
    assert measured.cycles == 102
    assert measured.misses == 2 + 2 * 20
    result = measured.result()
    assert result["wakeup_latency_us"]["p50"] == pytest.approx(3.0, abs=1.0)
    assert result["wakeup_latency_us"]["max"] == pytest.approx(20_000.0)


def test_cyclictest_that_prints_nothing_measures_nothing() -> None:
    """As where it is not allowed to run."""
    measured = Measured()
    cyclictest.add_histogram("", measured, 0.001)
    assert measured.cycles == 0
