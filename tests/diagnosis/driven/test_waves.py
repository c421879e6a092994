"""A torque ripple's wave, beside what a world of its own hides."""

import pytest

from stillarm.diagnosis.driven.blocks import irregular
from stillarm.diagnosis.driven.start import linear_start
from stillarm.diagnosis.driven.waves import strongest_waves
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make


@pytest.mark.slow
def test_the_strongest_wave_is_the_ripples() -> None:
    """Its encoder is so noisy that the twice differentiated angle shows nothing; the velocity does."""
    case = make(424200037, "torque_ripple")
    assert case.effect is not None
    driven = driven_of(case)
    start = linear_start(driven, irregular(driven.duration_s))
    strongest = strongest_waves(start)[0]
    turns = 12.0 + 60.0 * case.effect.chance[0]
    assert strongest.cycles == pytest.approx(turns, abs=1.0)
    size = case.effect.size / case.rig.inertia
    assert (strongest.sine**2 + strongest.cosine**2) ** 0.5 == pytest.approx(size, rel=0.15)
