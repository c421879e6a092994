"""What `stillarm latency` measures."""

from stillarm.benchmarks.loop.latency import run as run_latency


def test_latency_has_the_names_of_the_file() -> None:
    """A tenth of a second; what this machine gives is not judged."""
    result = run_latency(0.1)
    for name in ("loop", "floor"):
        assert set(result[name]) == {"wakeup_latency_us", "deadline_misses", "cycles"}
        assert set(result[name]["wakeup_latency_us"]) == {"p50", "p99", "p999", "max"}
        assert result[name]["cycles"] > 0
    assert set(result["compute_us"]) == {"p50", "p99", "p999", "max"}
    assert list(result["sections"]) == [
        "sense",
        "receive",
        "estimate",
        "decide",
        "command",
        "record",
        "sleep",
    ]
    for row in result["sections"].values():
        assert set(row) == {"us", "floor_us", "calls", "allocations"}
