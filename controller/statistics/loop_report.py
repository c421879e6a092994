"""One second of the loop for the browser panel: percentiles and coarse histograms, as one datagram. Pure.

docs/telemetry.md describes the map. Sent by the statistics process, never by the loop.
"""

from bisect import bisect_left
from collections.abc import Sequence
from itertools import accumulate

import msgspec

from stillarm.controller.statistics.histogram import BINS, bin_start_us, percentiles_us

EDGES_US = (0, 2, 5, 10, 20, 35, 50, 75, 100, 150, 200, 300, 500, 750, 1000, 2000, 5000, 10000)
"""Where the histogram's bins begin, us. The last one holds everything longer."""
_STARTS_US = [bin_start_us(index) for index in range(BINS)]
_ENCODE = msgspec.msgpack.Encoder().encode


def coarse(counts: Sequence[int]) -> list[int]:
    """The counts of a MicrosecondHistogram, or a difference of two, in the bins of EDGES_US; the sum stays."""
    sums = [0, *accumulate(counts)]
    at = [bisect_left(_STARTS_US, edge) for edge in EDGES_US]
    return [sums[end] - sums[begin] for begin, end in zip(at, [*at[1:], len(counts)], strict=True)]


def loop_report(
    cycle: int, lateness: Sequence[int], compute: Sequence[int], cycles: int, missed: int
) -> bytes:
    """The datagram of the second that ends with `cycle`.

    lateness, compute: counts of that second by bin of MicrosecondHistogram. cycles, missed: of that second.
    """

    def told(counts: Sequence[int]) -> dict[str, object]:
        p50, p99, p999, greatest = percentiles_us(counts, (0.5, 0.99, 0.999, 1.0))
        return {"p50_us": p50, "p99_us": p99, "p999_us": p999, "max_us": greatest, "counts": coarse(counts)}

    second = {
        "cycle": cycle,
        "cycles": cycles,
        "missed": missed,
        "edges_us": EDGES_US,
        "wakeup_latency": told(lateness),
        "compute": told(compute),
    }
    return _ENCODE([{"loop_second": second}])
