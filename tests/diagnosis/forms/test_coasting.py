"""A play behind which the link coasts is found from what the encoder saw, and nothing is where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.forms import coasting
from stillarm.diagnosis.forms.cause import Context
from stillarm.diagnosis.forms.coasting import CAUSE
from stillarm.diagnosis.physics.quantities import COASTING
from stillarm.diagnosis.physics.world import World
from tests.fixtures.synthetic import MODEL, fitted, measured

NOISE = 1e-3  # of the encoder, rad


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gap", "drag", "teeth_hz", "damping"), [(30.0, 2.0, 80.0, 0.2), (2.0, 8.0, 60.0, 0.3)]
)
def test_a_search_begins_at_the_play(gap: float, drag: float, teeth_hz: float, damping: float) -> None:
    """Also where it is no wider than two deviations of the encoder's noise."""
    hidden = dict(zip(COASTING, (gap * NOISE, drag, teeth_hz, damping), strict=True))
    (trial,) = CAUSE.trials(Context(fitted(measured(20.0, 3, hidden)), {}))
    assert trial.columns[0][COASTING[0]] == pytest.approx(gap * NOISE, rel=0.03)
    assert trial.shape[COASTING[1]] == pytest.approx(drag, rel=0.3)


@pytest.mark.slow
def test_a_narrow_play_is_seen_by_a_fine_encoder_as_the_simulation_has_it() -> None:
    truth = (0.0006, 2.0, 90.0, 0.15)
    hidden = dict(zip(COASTING, truth, strict=True))
    plain, random = measured(20.0, 3, hidden), np.random.default_rng(4)
    world = World(plain, MODEL)
    shown = world.predict(world.space.with_values(world.space.vector(), hidden)).channels
    position = shown["joint_position"] + random.normal(0.0, 0.02 * NOISE, plain.cycles)
    velocity = shown["joint_velocity"] + random.normal(0.0, NOISE, plain.cycles)
    context = Context(fitted(replace(plain, position=position, velocity=velocity)), {})
    (trial,) = CAUSE.trials(context)
    assert trial.columns[0][COASTING[0]] == pytest.approx(0.0006, rel=0.02)
    seen = coasting._seen(context)
    assert seen is not None
    a_cycle_late = replace(seen, command=np.roll(seen.command, 1))
    assert seen.cost(truth, 1.0) < 1.3 * seen.least < 0.5 * a_cycle_late.cost(truth, 1.0)


@pytest.mark.parametrize(
    "hidden",
    [{}, {"drive.further_dead_time_s": 0.01}, {"drive.further_lag_s": 0.02}, {"drive.friction_rad_s": 0.01}],
)
def test_no_play_is_none(hidden: dict[str, float]) -> None:
    assert CAUSE.trials(Context(fitted(measured(10.0, 3, hidden)), {})) == []


def test_means_are_of_what_is_known() -> None:
    values = np.array([1.0, np.nan, 3.0, np.nan, np.nan, np.nan, np.nan, np.nan, 5.0, 5.0, 7.0, 7.0, 9.0])
    assert coasting._means(values, 4) == pytest.approx([2.0, np.nan, 6.0], nan_ok=True)
