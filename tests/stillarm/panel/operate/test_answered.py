"""What the controller's telemetry says about an adjustment."""

from math import nan

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Controller
from stillarm.controller.safety.adjusting import Adjusted
from stillarm.panel.live.known import Known
from stillarm.panel.live.telemetry import Line, Row, Words
from stillarm.panel.operate.answered import in_force, refusal_since

ASKED = Adjustment("", 0.05)


def heard(*rows: Row) -> Known:
    known = Known()
    known.take(list(rows), 1.0)
    return known


def test_nothing_is_in_force_before_it_was_told() -> None:
    assert not in_force(ASKED, Known())
    assert not in_force(Adjustment("fused", nan), Known())


def test_what_was_asked_for_is_in_force_when_the_words_hold_it() -> None:
    known = heard(Row(2.0, words=Words(method="fused", added_damping_ratio=0.05)))
    assert in_force(ASKED, known)
    assert in_force(Adjustment("fused", 0.05), known)
    assert not in_force(Adjustment("timestamps", 0.05), known)
    assert not in_force(Adjustment("fused", 0.06), known)


def test_a_refusal_is_told_with_its_reason_and_an_older_one_is_not() -> None:
    level, text = Adjusted(ASKED, Controller(), "the state is degraded").told
    known = heard(Row(2.0, log=Line(level, text)), Row(3.0, log=Line("info", "state armed")))
    assert refusal_since(known, nan) == "the state is degraded"
    assert refusal_since(known, 1.9) == "the state is degraded"
    assert refusal_since(known, 2.0) == ""


def test_an_adjustment_that_was_taken_is_no_refusal() -> None:
    assert refusal_since(heard(Row(2.0, log=Line(*Adjusted(ASKED, Controller(), "").told))), nan) == ""
