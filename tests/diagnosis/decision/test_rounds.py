"""Which form stands for a cause in a round of the search. What a round takes: test_explain.py."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision import rounds
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.search.candidates import Candidate

LAST = cast(Fit, SimpleNamespace())


def candidate(cause: str, form: str, merit: float) -> Candidate:
    return Candidate(cause, LAST, 0.0, 0.0, {}, form=form, merit=merit, nats=np.zeros(3))


@pytest.mark.parametrize(
    ("convincing", "expected"),
    [
        ({"straight", "walk", "other"}, [("delay_drift", "straight"), ("clock_step", "other")]),
        ({"walk", "other"}, [("clock_step", "other"), ("delay_drift", "walk")]),
        ({"course"}, [("clock_step", "other"), ("delay_drift", "course")]),
        (set(), [("delay_drift", "straight"), ("clock_step", "other")]),
    ],
)
def test_the_best_form_that_convinces_stands_for_its_cause(
    monkeypatch: pytest.MonkeyPatch, convincing: set[str], expected: list[tuple[str, str]]
) -> None:
    monkeypatch.setattr(rounds, "convinces", lambda one, *_: one.form in convincing)
    tried = [
        candidate("delay_drift", "course", 14.0),
        candidate("delay_drift", "straight", 40.0),
        candidate("clock_step", "other", 30.0),
        candidate("delay_drift", "walk", 17.0),
    ]
    best = rounds._best_that_convinces(tried, LAST, interleaved(20.0), beside=False)
    assert [(one.cause, one.form) for one in best] == expected


@pytest.mark.parametrize(
    ("first", "second", "leads"),
    [
        (("drive_deadband", 900.0), ("stiffness_drift", 4000.0), 1),
        (("drive_deadband", 4000.0), ("stiffness_drift", 900.0), 0),
        (("cubic_stiffness", 900.0), ("stiffness_drift", 4000.0), 0),
    ],
)
def test_what_tells_most_leads_whatever_the_drive_did(
    first: tuple[str, float], second: tuple[str, float], leads: int
) -> None:
    findings = [candidate(cause, "", merit) for cause, merit in (first, second)]
    assert rounds._largest_first(findings)[0] is findings[leads]
