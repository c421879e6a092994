"""Processors that are slowed down or taken away."""

import os
from pathlib import Path

from stillarm.controller.statistics.processor_watch import Stolen, Throttling


def test_throttling_is_seen_by_count_or_clock(tmp_path: Path) -> None:
    """Files as Linux has them; none of them means never."""
    assert not Throttling(tmp_path).seen()
    count = tmp_path / "cpu0" / "thermal_throttle" / "core_throttle_count"
    clock = tmp_path / "cpu0" / "cpufreq"
    count.parent.mkdir(parents=True)
    clock.mkdir()
    count.write_text("3\n")
    (clock / "cpuinfo_max_freq").write_text("3000000\n")
    (clock / "scaling_cur_freq").write_text("2900000\n")
    throttling = Throttling(tmp_path)
    assert not throttling.seen()
    count.write_text("4\n")
    assert throttling.seen()
    assert not throttling.seen()
    (clock / "scaling_cur_freq").write_text("1200000\n")
    assert throttling.seen()


def test_stolen_time_is_that_of_the_processors_that_may_be_used(tmp_path: Path) -> None:
    """/proc/stat as proc(5) has it; an old kernel's rows are shorter, and a missing file tells of nothing."""
    mine = max(os.sched_getaffinity(0))
    stat = tmp_path / "stat"

    def write(steal: int, of_another: int) -> None:
        stat.write_text(
            f"cpu  9 9 9 9 9 9 9 {steal + of_another} 0 0\n"
            f"cpu{mine} 1 2 3 4 5 6 7 {steal} 0 0\ncpu999 1 2 3 4 5 6 7 {of_another} 0 0\nintr 5\n"
        )

    write(10, 50)
    stolen = Stolen(os.getpid(), stat)
    assert stolen.passed_s() == 0.0
    write(13, 90)
    assert stolen.passed_s() == 3.0 / os.sysconf("SC_CLK_TCK")
    assert stolen.passed_s() == 0.0
    stat.write_text("cpu 1 2 3\ncpu0 1 2 3\n")
    assert stolen.passed_s() == 0.0
    assert Stolen(os.getpid(), tmp_path / "absent").passed_s() == 0.0
