"""The tables of the kills."""

from stillarm.benchmarks.live.kills.kill_tables import by_gap, verdict


def test_tables_count_the_kills_of_each_gap_and_judge_them() -> None:
    rows = [
        {"method": "fused", "gap_asked_s": gap, "gap_s": gap + 0.1, "settled_s": settled, "error_mean": 0.01,
         "error_max": 0.03, "amplitude_m": 0.002, "delay_normalised_error_squared_max": 1.0,
         "deflection_normalised_error_squared_max": honest, "longest_beyond_2_std_s": 0.1}
        for gap, settled, honest in ((0.3, 0.5, 1.0), (0.3, 1.2, 4.0), (3.0, None, None))
    ]  # fmt: skip
    first, second = by_gap(rows)
    assert (first["kills"], first["within 1 s"], first["worst"]) == (2, 1, "1.20")
    assert first["gap, s"] == "0.40 to 0.40"
    assert (second["kills"], second["within 1 s"], second["settled, s"]) == (1, 0, "-")
    assert [row["kept after"] for row in verdict(rows)] == ["1 of 3 kills", "2 of 3 kills", "3 of 3 kills"]
