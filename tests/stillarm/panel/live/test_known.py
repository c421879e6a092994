"""What is known of the loop: silence, a restarted controller, and the age of its samples."""

from math import isinf

import pytest

from stillarm.panel.live.known import SILENT_S, Known
from stillarm.panel.live.telemetry import Fast, Line, Row, Words


def fast(time_s: float, allowed: bool = True) -> Row:
    return Row(time_s, fast=Fast(damping_allowed=allowed))


def test_silence_begins_after_the_last_row() -> None:
    known = Known()
    assert known.silent(0.0)
    known.take([fast(1.0)], 10.0)
    assert not known.silent(10.0 + 0.9 * SILENT_S)
    known.take([], 10.3)  # a datagram that is no telemetry is no sign of life
    assert known.silent(10.0 + 1.1 * SILENT_S)


def test_a_controller_on_this_computer_says_its_origin() -> None:
    known = Known()
    known.take([Row(0.0, words=Words("armed", origin_monotonic_s=100.0)), fast(1.0)], 101.03)
    assert known.origin() == (100.0, True)


def test_another_computers_clock_is_taken_from_the_quickest_datagram() -> None:
    known = Known()
    known.take([Row(0.0, words=Words("armed", origin_monotonic_s=77_000.0))], 101.0)
    for time_s, late_s in ((1.0, 0.03), (1.03, 0.02), (1.06, 0.05)):
        known.take([fast(time_s)], 100.0 + time_s + late_s)
    origin_s, exact = known.origin()
    assert not exact and origin_s == pytest.approx(100.02)


def test_a_restarted_controller_has_another_zero() -> None:
    known = Known()
    known.take([Row(0.0, words=Words("damping", origin_monotonic_s=100.0)), fast(50.0, False)], 150.02)
    assert not known.damping_allowed
    known.take([fast(0.0)], 200.02)
    known.take([Row(0.1, words=Words("preflight", origin_monotonic_s=200.0)), fast(0.1)], 200.12)
    assert known.origin() == (200.0, True) and known.words.state == "preflight" and known.damping_allowed


def test_log_lines_are_kept_within_bounds() -> None:
    known = Known()
    known.take([Row(float(i), log=Line("warning", f"line {i}")) for i in range(200)], 0.0)
    assert len(known.lines) == 50 and known.lines[-1]["text"] == "line 199"
    assert isinf(known.origin()[0])
