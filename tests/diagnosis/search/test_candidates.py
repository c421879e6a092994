"""When two candidates explain the same, and which of two is ahead."""

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.search.candidates import Candidate, by_one_measure, explains_the_same
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


@pytest.mark.parametrize(
    ("whole", "held", "course_leads"),
    [
        (2300.0, 600.0, True),
        (2300.0, 545.0, False),  # by no more than chance
        (2300.0, 500.0, False),  # it follows what it was fitted to
        (1900.0, 600.0, False),  # the formula tells all blocks better
    ],
)
def test_a_course_that_leads_by_all_blocks_and_by_those_held_out_is_ahead(
    plain: Fit, whole: float, held: float, course_leads: bool
) -> None:
    """A course's merit is what it foretells; a formula's is by all blocks, of which some say more than the others."""
    split = interleaved(20.0)
    per_held = split.blocks_per_held
    formula = Candidate("camera_tilt_coupling", plain, 540.0, 1.0, {}, merit=1926.0, nats=np.full(8, 241.0))
    course = Candidate(
        "accelerometer_sensitivity_drift", plain, held, 1.0, {}, merit=min(whole, per_held * held, 1925.0),
        nats=np.full(8, whole / 8.0),
    )  # fmt: skip
    small = Candidate("mains_hum", plain, 2.0, 1.0, {}, merit=70.0, nats=np.full(8, 9.0))
    ranked = by_one_measure([small, formula, course], split)
    assert [one.cause for one in ranked] == [
        *([course.cause, formula.cause] if course_leads else [formula.cause, course.cause]), small.cause,
    ]  # fmt: skip
    assert ranked[-1].merit == (2.0 * per_held if course_leads else 70.0)
