"""The turns of `benchmark panel` make one row for each number of pages."""

from stillarm.benchmarks.panel_pages import summed


def part(p999: float, misses: int, **other: object) -> dict[str, object]:
    return {
        "wakeup_latency_us": {"p50": 30.0, "p999": p999},
        "deadline_misses": misses,
        "cycles": 1000,
    } | other


def test_latencies_are_medians_counts_are_sums_and_the_server_is_judged_by_its_worst_turn() -> None:
    parts = [part(p999, 2, share=p999 / 1e4, mib=50.0, ages_s=[0.02, 0.04]) for p999 in (100.0, 300.0, 200.0)]
    row = summed(20, parts)
    assert (row["pages"], row["wakeup_p999_us"], row["deadline_misses"], row["cycles"]) == (
        "20",
        200.0,
        6,
        3000,
    )
    assert abs(row["server_core_percent"] - 3.0) < 1e-9 and row["server_mib"] == 50.0
    assert abs(row["age_p50_ms"] - 30.0) < 1e-9


def test_without_a_panel_there_is_no_server_to_judge() -> None:
    row = summed(None, [part(100.0, 0)])
    assert row["pages"] == "no panel" and row["server_mib"] is None and row["age_p99_ms"] is None
