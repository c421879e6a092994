"""What sets in on the way is seen from the baseline of what was before, and only then is that looked at."""

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.physics.quantities import DRIVE_BEGIN
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.baseline import fitted_baseline
from stillarm.diagnosis.search.early_baseline import early_baseline
from tests.fixtures.synthetic import MODEL, NOISE, fitted, measured

SECONDS, LATE_S, BEGINS_S = 18.0, 0.12, 10.4
LATER = {"drive.further_dead_time_s": LATE_S, DRIVE_BEGIN: BEGINS_S}


@pytest.mark.slow
def test_a_drive_that_answers_late_from_an_instant_on_is_found_by_what_was_before() -> None:
    data, split = measured(SECONDS, 2, LATER), interleaved(SECONDS)
    baseline = fitted_baseline(World(data, MODEL), split)
    early = early_baseline(baseline, split)
    assert early is not None
    shown = early.channel("acceleration")
    assert shown is not None
    before = early.world.cycle_times < BEGINS_S
    assert float(np.nanstd(shown.off[before])) == pytest.approx(NOISE["acceleration"], rel=0.1)
    found = explain(baseline, split, only=["drive_dead_time", "drive_lag", "coulomb_damping"])
    assert found.findings[0].cause == "drive_dead_time"
    assert found.findings[0].begins_s == pytest.approx(BEGINS_S, abs=0.5)


def test_where_nothing_sets_in_there_is_no_other_baseline() -> None:
    assert early_baseline(fitted(measured(SECONDS, 2)), interleaved(SECONDS)) is None
