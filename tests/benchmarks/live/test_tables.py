"""The live benchmark's tables and their verdict."""

from stillarm.benchmarks.live.scoring import score
from stillarm.benchmarks.live.tables import by_method, by_run, verdict
from tests.fixtures.live_rows import perfect, true_run


def test_the_tables_take_every_row_and_judge_the_method_that_damps() -> None:
    """Rows as of a run, with a score missing."""
    shared = {
        "seed": 3, "settling_time_damped_s": 1.5, "frames": 10, "frames_lost": 0, "cycles": 9, "deadline_misses": 2,
        "own_deadline_misses": 1, "floor_cycles": 9, "floor_deadline_misses": 1,
        "command_max_rad_s": 0.1, "commands_beyond_limits": 0, "commands_without_grounds": 0,
    }  # fmt: skip
    scores = score(perfect(true_run()), true_run())
    rows = [
        {"run": run, "method": method, **shared, **scores, "longest_beyond_2_std_s": beyond}
        for run, beyond in ((0, 0.1), (1, 0.7))
        for method in ("timestamps", "fused")
    ]
    rows[0]["delay_rms_s"] = None
    assert [row["method"] for row in by_method(rows)] == ["timestamps", "fused"]
    assert [row["run"] for row in by_run(rows)] == [0, 1]
    assert [row["> 2 std, s"] for row in by_run(rows)] == ["0.10", "0.70"]
    kept = {row["asked"]: row["kept in"] for row in verdict(rows)}
    assert list(kept.values()) == ["2 of 2 runs", "1 of 2 runs", *["2 of 2 runs"] * 3, "0 of 2 runs"]
    rows.append({**rows[0], "method": "correlation", "run": 0, "error_mean": 0.02})
    rows.append({**rows[0], "method": "correlation", "run": 1, "error_mean": -1.0})
    assert verdict(rows)[-1] == {"asked": "fused better than correlation", "kept in": "1 of 2 runs"}
    bounded = [{**row, "bound_mean": 0.012 if row["run"] else 0.006} for row in rows]
    assert [row["bound, %"] for row in by_run(bounded)] == ["0.60", "1.20"]
    assert verdict(bounded)[1]["asked"].startswith("the same of the bound")
    assert verdict(bounded)[1]["kept in"] == "1 of 2 runs"


def test_the_arm_is_to_settle_sooner_where_nothing_runs_beside_it() -> None:
    row = {
        "run": 0, "method": "fused", "error_mean": None, "longest_beyond_2_std_s": None,
        "settling_time_damped_s": 2.0, "commands_beyond_limits": 0, "commands_without_grounds": 1, "frames_lost": 0,
        "own_deadline_misses": 0,
    }  # fmt: skip
    assert [kept["kept in"][0] for kept in verdict([row])] == ["0", "1", "0", "0", "1", "1"]
    assert [kept["kept in"][0] for kept in verdict([row], load=2)] == ["0", "1", "1", "0", "1", "1"]
