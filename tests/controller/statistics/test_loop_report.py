"""The second that the panel is told of: nothing is lost in coarse bins, and the percentiles are the histogram's."""

import msgpack
from hypothesis import given
from hypothesis import strategies as st

from stillarm.controller.statistics.histogram import MicrosecondHistogram
from stillarm.controller.statistics.loop_report import EDGES_US, coarse, loop_report


@given(st.lists(st.integers(0, 20_000), max_size=200))
def test_each_duration_falls_into_the_bin_whose_edges_enclose_it(durations_us: list[int]) -> None:
    histogram = MicrosecondHistogram()
    for microseconds in durations_us:
        histogram.add((microseconds + 0.5) * 1e-6)
    counts = coarse(histogram.counts())
    assert sum(counts) == len(durations_us)
    linear = [us for us in durations_us if us < 2000]  # there the histogram's own bins are exact
    for begin, end, count in zip(EDGES_US, EDGES_US[1:], counts, strict=False):
        if end <= 2000:
            assert count == sum(begin <= us < end for us in linear)


def test_the_datagram_holds_one_second() -> None:
    histogram = MicrosecondHistogram()
    for microseconds in range(1000):
        histogram.add((microseconds + 0.5) * 1e-6)
    counts = histogram.counts()
    (told,) = msgpack.unpackb(loop_report(5000, counts, counts, 998, 2))
    second = told["loop_second"]
    assert (second["cycle"], second["cycles"], second["missed"]) == (5000, 998, 2)
    assert abs(second["compute"]["p50_us"] - 500) <= 1 and second["wakeup_latency"]["max_us"] == 999
    assert len(second["edges_us"]) == len(second["compute"]["counts"])
