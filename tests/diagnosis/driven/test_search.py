"""Play that a world of its own hides: contacts that give way, where the diagnosis has inelastic impacts."""

import pytest

from stillarm.diagnosis.driven.blocks import irregular
from stillarm.diagnosis.driven.judging import CONVINCES
from stillarm.diagnosis.driven.search import tried_forms
from stillarm.diagnosis.driven.start import linear_start
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make


@pytest.mark.slow
@pytest.mark.parametrize("seed", [424200012, 424200024])
def test_play_is_found_with_its_gap_with_and_without_a_mode(seed: int) -> None:
    """Behind a motor's encoder and a bending arm; between a link's encoder and a motor's velocity."""
    case = make(seed, "gear_backlash")
    assert case.effect is not None
    driven = driven_of(case)
    start = linear_start(driven, irregular(driven.duration_s))
    best = tried_forms(start, lambda: 1e9)[0]
    assert best.form.cause == "gear_backlash" and best.merit > CONVINCES
    # an angle of the motor is before the gear, whose ratio the diagnosis does not know
    ratio = case.rig.drive.gear_ratio if any(one.kind == "motor" for one in driven.outputs) else 1.0
    assert best.fit.numbers["gap"] == pytest.approx(ratio * case.effect.size, rel=0.25)
