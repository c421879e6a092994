"""The judge finds every violation, and nothing else."""

from math import nan

from stillarm.benchmarks.faults.judge import Trace, Verdict, judge, table

TIMES = [i * 0.001 for i in range(1000)]


def of(
    commands: list[float], groundless: tuple[float, float] | None = None, back: float | None = None
) -> Verdict:
    return judge("k", Trace(TIMES, commands), limit_rad_s=0.6, groundless_s=groundless, back_by_s=back)


def test_a_command_beyond_its_limits() -> None:
    assert of([0.6] * 1000).violations == []
    for wrong in (0.61, -0.7, nan):
        (text,) = of([0.1] * 500 + [wrong] + [0.1] * 499).violations
        assert "0.500 s" in text


def test_a_command_without_grounds() -> None:
    still = of([0.1] * 150 + [0.0] * 850, (0.0, 0.8))
    assert still.violations == [] and abs((still.reaction_s or 0.0) - 0.149) < 1e-9
    (text,) = of([0.1] * 250 + [0.0] * 750, (0.0, 0.8)).violations
    assert "0.249 s" in text
    (text,) = of([0.0] * 600 + [1e-6] + [0.0] * 399, (0.0, 0.8)).violations  # for one millisecond, and little
    assert "0.600 s" in text
    assert of([0.0] * 800 + [0.1] * 200, (0.0, 0.8)).violations == []


def test_one_that_does_not_come_back() -> None:
    (text,) = of([0.0] * 1000, (0.0, 0.5), 0.9).violations
    assert "not back" in text
    assert of([0.0] * 850 + [0.1] * 150, (0.0, 0.5), 0.9).violations == []


def test_the_table_counts() -> None:
    verdicts = [Verdict("a", 0.1, 0.2, 3), Verdict("b", None, 0.1), Verdict("a", 0.15, 0.1, 4, ["x", "y"])]
    result = table(verdicts)
    assert (result["injections"], result["kinds"], result["violations"]) == (3, 2, 2)
    assert result["rows"] == [
        {
            "kind": "a",
            "times": 2,
            "reaction_s_max": 0.15,
            "command_max": 0.2,
            "messages_lost": 7,
            "violations": 2,
        },
        {
            "kind": "b",
            "times": 1,
            "reaction_s_max": None,
            "command_max": 0.1,
            "messages_lost": 0,
            "violations": 0,
        },
    ]
