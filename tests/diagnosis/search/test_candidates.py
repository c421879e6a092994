"""When two candidates explain the same."""

import pytest

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.search.candidates import Candidate, explains_the_same
from tests.fixtures.synthetic import fitted, measured


@pytest.fixture(scope="module")
def plain() -> Fit:
    return fitted(measured(6.0, 1))


@pytest.mark.parametrize(("there", "same"), [(0.0, False), (30.0, False), (40.0, True), (150.0, True)])
def test_a_candidate_explains_the_same_where_it_gains_much_in_the_others_channel(
    plain: Fit, there: float, same: bool
) -> None:
    clock = Candidate("clock_step", plain, 1.0, 1.0, {}, gains={"arrival": 100.0, "acceleration": 1.0})
    mode = Candidate(
        "second_bending_mode", plain, 1.0, 1.0, {}, gains={"acceleration": 600.0, "arrival": there}
    )
    assert explains_the_same(mode, clock) == same
    assert not explains_the_same(clock, mode)
