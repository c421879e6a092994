"""The loop's benchmark: what it adds up, and what it asks for. No timing of this machine is judged here."""

from stillarm.benchmarks.loop.run import verdict


def test_the_verdict_is_the_one_that_is_asked_for() -> None:
    """1.5 times the floor's 99th percentile; 1.5 m + 3 sqrt(m) + 3 misses; 300 us."""

    def result(p99: float, misses: int, compute: float) -> dict[str, object]:
        loop = {"wakeup_latency_us": {"p99": p99}, "deadline_misses": misses}
        floor = {"wakeup_latency_us": {"p99": 40.0}, "deadline_misses": 4}
        return {"loop": loop, "floor": floor, "compute_us": {"p99": compute}}

    assert [row["kept"] for row in verdict(result(60.0, 15, 300.0))] == ["yes", "yes", "yes"]
    assert [row["kept"] for row in verdict(result(60.1, 16, 300.1))] == ["no", "no", "no"]
