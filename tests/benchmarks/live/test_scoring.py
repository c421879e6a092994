"""Scores of the live benchmark against errors that are known beforehand, and commands that break their limits."""

from dataclasses import replace
from math import inf, nan, pi
from pathlib import Path

import numpy as np
import pytest

from stillarm.benchmarks.live.commands import judge_commands
from stillarm.benchmarks.live.misses import Gap, gaps, own_misses
from stillarm.benchmarks.live.replay_tables import read_estimates
from stillarm.benchmarks.live.run import damped_settling_s, frames_lost
from stillarm.benchmarks.live.scoring import Estimates, period_s, score
from stillarm.benchmarks.live.tables import by_method, by_run, verdict
from stillarm.benchmarks.live.truth import Swing, TrueRun
from stillarm.common.files.model import Drive

W = 2.0 * pi * 2.5
A = 0.006
DELAY_S = 0.075


def true_run() -> TrueRun:
    """Struck at 2 s, rings with 1 % damping; struck again at 18 s and damped with 13 %."""
    t = np.arange(-1.0, 30.0, 0.002)
    q = np.where(t >= 2.0, A * np.exp(-0.01 * W * (t - 2.0)) * np.sin(W * (t - 2.0)), 0.0)
    damped = A * np.exp(-0.13 * W * (t - 18.0)) * np.sin(W * (t - 18.0))
    mid = {k: k / 65.0 for k in range(2000)}
    return TrueRun(t, np.where(t >= 18.0, damped, q), mid, (Swing(2.0, 17.75), Swing(18.0, 29.998)))


def perfect(truth: TrueRun) -> Estimates:
    t = np.arange(0.0, 29.9, 0.001)
    q = np.interp(t, truth.time_s, truth.deflection_m)
    frame = np.arange(100, 1900)
    received = frame / 65.0 + DELAY_S
    n = len(frame)
    return Estimates(t, q, np.full(len(t), 1e-4), frame, received, np.full(n, DELAY_S), np.full(n, 1e-3))


def test_a_perfect_estimate_has_no_error() -> None:
    found = score(perfect(true_run()), true_run())
    for key in ("error_mean", "error_max", "lost_share", "settled_s", "longest_beyond_2_std_s"):
        assert found[key] == pytest.approx(0.0, abs=1e-9), key
    for key in ("delay_rms_s", "delay_mean_s", "delay_normalised_error_squared_max"):
        assert found[key] == pytest.approx(0.0, abs=1e-9), key
    assert period_s(true_run()) == pytest.approx(0.4, abs=0.003)


def test_an_error_in_proportion_to_the_amplitude_is_told_as_that_share() -> None:
    """A phase error of e rad is an error of e times the amplitude, 2 e / pi on average."""
    truth = true_run()
    said = perfect(truth)
    early = np.interp(said.time_s + 0.1 / W, truth.time_s, truth.deflection_m)
    found = score(replace(said, deflection_m=early), truth)
    assert found["error_mean"] == pytest.approx(0.2 / pi, rel=0.1)
    assert found["error_max"] == pytest.approx(0.1, rel=0.35)  # the decay makes up for the rest


def test_what_was_not_said_counts_as_an_error_of_the_whole_amplitude() -> None:
    truth = true_run()
    said = perfect(truth)
    found = score(replace(said, deflection_m=np.full(len(said.time_s), nan)), truth)
    assert found["error_mean"] == 1.0 and found["lost_share"] == 1.0
    assert found["longest_beyond_2_std_s"] is None


def test_the_normalised_error_is_that_of_the_worst_window() -> None:
    """Three deviations off in one window of the delay, one everywhere else."""
    truth = true_run()
    said = perfect(truth)
    off = np.where((said.received_s >= 7.0) & (said.received_s < 12.0), 3e-3, 1e-3)
    found = score(replace(said, delay_s=DELAY_S + off), truth)
    assert found["delay_normalised_error_squared_max"] == pytest.approx(9.0, rel=1e-6)
    assert found["deflection_normalised_error_squared_max"] == pytest.approx(0.0, abs=1e-9)


def test_a_time_beyond_two_deviations_is_not_ended_by_the_errors_crossings_of_zero() -> None:
    """An error in quadrature from 5 to 7 s, of ten deviations; and a spike of 20 ms elsewhere."""
    truth = true_run()
    said = perfect(truth)
    t = said.time_s
    wrong = np.where((t >= 5.0) & (t < 7.0), 1e-3 * np.cos(W * t), 0.0) + np.where(
        (t > 10.0) & (t < 10.02), 1e-3, 0.0
    )
    found = score(replace(said, deflection_m=said.deflection_m + wrong), truth)
    assert found["longest_beyond_2_std_s"] == pytest.approx(2.0, abs=0.06)
    spike = np.where((t > 10.0) & (t < 10.02), 1e-3, 0.0)
    found = score(replace(said, deflection_m=said.deflection_m + spike), truth)
    assert found["longest_beyond_2_std_s"] == pytest.approx(0.02, abs=0.003)


def test_settling_counts_from_the_strike_to_the_last_time_above() -> None:
    truth = true_run()
    said = perfect(truth)
    wrong = np.where((said.time_s >= 2.0) & (said.time_s < 5.0), 0.5 * said.deflection_m, said.deflection_m)
    assert score(replace(said, deflection_m=wrong), truth)["settled_s"] == pytest.approx(3.0, abs=0.3)
    damped = damped_settling_s(truth, 2.5)
    assert damped == pytest.approx(np.log(20.0) / (0.13 * W), abs=0.25)


def test_frames_between_the_first_and_the_last_that_are_missing_are_lost() -> None:
    assert frames_lost([]) == 0 and frames_lost([5, 6, 7]) == 0 and frames_lost([5, 8, 9]) == 2


def judged(commands: list[float], states: list[str]) -> dict[str, float | int]:
    drive = Drive(max_velocity_rad_s=0.6, max_acceleration_rad_s2=20.0)
    return judge_commands([0.001 * k for k in range(len(commands))], commands, states, drive, 0.001)


def test_commands_beyond_a_limit_are_counted() -> None:
    """20 mrad/s a cycle, 0.6 rad/s at the most; what is not finite is beyond any limit."""
    ramp = [0.02 * k for k in range(31)]
    assert judged(ramp, ["armed"] * 31)["commands_beyond_limits"] == 0
    assert judged([*ramp, 0.61], ["armed"] * 32)["commands_beyond_limits"] == 1
    assert judged([0.0, 0.03], ["armed"] * 2)["commands_beyond_limits"] == 1
    for wrong in (nan, inf):
        assert judged([0.0, wrong, 0.0], ["armed"] * 3)["commands_beyond_limits"] == 1
    assert judged(ramp, ["armed"] * 31)["command_max_rad_s"] == pytest.approx(0.6)


def test_commands_without_grounds_are_counted_once_the_time_to_fade_is_over() -> None:
    """0.1 s after the permission is gone; before any was given, at once."""
    states = ["damping"] * 10 + ["idle"] * 300
    fading = [0.01] * 10 + [0.01 * (1.0 - k / 90.0) for k in range(90)] + [0.0] * 210
    assert judged(fading, states)["commands_without_grounds"] == 0
    assert judged([0.01] * 310, states)["commands_without_grounds"] == pytest.approx(200, abs=1)
    assert judged([0.01, 0.01], ["idle", "idle"])["commands_without_grounds"] == 2


def test_a_miss_is_the_loops_own_where_the_bare_timer_missed_none() -> None:
    """A stall that hits both does not hit them at the same instant."""
    loop = gaps([0, 1, 5, 6, 50, 51, 53])
    assert loop == [Gap(1, 3), Gap(6, 43), Gap(51, 1)]
    assert own_misses(loop, []) == 47
    assert own_misses(loop, [Gap(2, 3), Gap(30, 2)]) == 1
    assert own_misses(loop, [Gap(0, 60)]) == 0
    assert own_misses([], [Gap(0, 60)]) == 0


def test_tables_are_read_back_with_empty_fields_as_nothing(tmp_path: Path) -> None:
    (tmp_path / "estimates.csv").write_text(
        "time_s,method,status,deflection_m,deflection_std_m\n0.0,a,x,,\n0.001,a,x,0.5,0.1\n0.0,b,x,1.0,2.0\n"
    )
    (tmp_path / "frames.csv").write_text(
        "frame,received_s,method,status,delay_s,delay_std_s\n7,0.5,a,estimated,0.07,0.001\n"
    )
    said = read_estimates(tmp_path)
    assert list(said) == ["a", "b"]
    assert np.isnan(said["a"].deflection_m[0]) and said["a"].deflection_std_m[1] == 0.1
    assert said["a"].frame.tolist() == [7] and said["b"].frame.tolist() == []


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


def test_the_arm_is_to_settle_sooner_where_nothing_runs_beside_it() -> None:
    row = {
        "run": 0, "method": "fused", "error_mean": None, "longest_beyond_2_std_s": None,
        "settling_time_damped_s": 2.0, "commands_beyond_limits": 0, "commands_without_grounds": 1, "frames_lost": 0,
        "own_deadline_misses": 0,
    }  # fmt: skip
    assert [kept["kept in"][0] for kept in verdict([row])] == ["0", "1", "0", "0", "1", "1"]
    assert [kept["kept in"][0] for kept in verdict([row], load=2)] == ["0", "1", "1", "0", "1", "1"]
