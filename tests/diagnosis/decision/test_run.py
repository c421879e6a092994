"""A diagnosis within its time. What it names: test_named.py."""

import pytest

from stillarm.diagnosis.decision import run as diagnosis
from stillarm.diagnosis.decision.budget import unlimited
from stillarm.diagnosis.decision.run import run
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.search.comparison import LEFT_OUT
from tests.fixtures.synthetic import MODEL, measured


def test_a_search_that_runs_out_of_time_is_told_and_leaves_the_baseline(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no_time(*_: object, **__: object) -> None:
        raise OutOfTime

    monkeypatch.setattr(diagnosis, "explain", no_time)
    outcome = run(measured(6.0, 3), MODEL, (), lambda done, what: None, unlimited())
    assert LEFT_OUT in outcome.left_out
    assert outcome.found.findings == [] and outcome.judged.verdict == "none"
