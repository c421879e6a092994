"""A play behind which the link coasts is found from what the encoder saw, and nothing is where there is none."""

import pytest

from stillarm.diagnosis.forms.cause import Context
from stillarm.diagnosis.forms.coasting import CAUSE
from stillarm.diagnosis.physics.quantities import COASTING
from tests.fixtures.synthetic import fitted, measured

HIDDEN = dict(zip(COASTING, (0.03, 2.0, 80.0, 0.2), strict=True))


@pytest.mark.slow
def test_a_search_begins_at_the_play() -> None:
    (trial,) = CAUSE.trials(Context(fitted(measured(20.0, 3, HIDDEN)), {}))
    assert trial.columns[0][COASTING[0]] == pytest.approx(HIDDEN[COASTING[0]], rel=0.03)
    assert trial.shape[COASTING[1]] == pytest.approx(HIDDEN[COASTING[1]], rel=0.3)


@pytest.mark.parametrize("hidden", [{}, {"drive.further_dead_time_s": 0.01}])
def test_no_play_is_none(hidden: dict[str, float]) -> None:
    assert CAUSE.trials(Context(fitted(measured(10.0, 3, hidden)), {})) == []
