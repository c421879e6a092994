"""A law without a name beats a listed one where it is the true one, and there alone."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.rival_laws import _as_stiff, rival_law
from stillarm.diagnosis.fitting.evidence import PRICE_NATS, score
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.forms.freeform import DRIVE
from stillarm.diagnosis.forms.sensor_walk import IMAGE_WALK as FORM
from stillarm.diagnosis.search.candidates import Candidate
from tests.fixtures.synthetic import fitted, measured

SPLIT = interleaved(20.0)
CUBIC = "arm.cubic_per_m2"


def _taken(before: Fit, start: float) -> Candidate:
    """A cubic stiffness as a search takes it."""
    world = before.world
    begun = world.space.with_values(world.space.vector(), {CUBIC: start})
    found = fit(make_data(world, SPLIT), begun, (*before.free, CUBIC), colour=before.colour)
    nats = score(found, SPLIT).gain(score(before, SPLIT))
    merit = float(nats.sum()) - PRICE_NATS
    return Candidate("cubic_stiffness", found, 0.0, 1.0, {}, free=(CUBIC,), merit=merit, nats=nats)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "rival_wins"),
    [
        ({"one_sided_stiffness.share": 0.2, "one_sided_stiffness.at_m": -0.02}, True),
        ({CUBIC: 30.0}, False),
    ],
)
def test_the_true_law_wins(hidden: dict[str, float], rival_wins: bool) -> None:
    before = fitted(measured(20.0, 5, hidden))
    first = _taken(before, 30.0)
    rival = rival_law(first, before, SPLIT)
    assert (rival is not None) == rival_wins
    if rival is not None:
        assert rival.merit > 1.05 * first.merit
        assert rival.fit.value("one_sided_stiffness.share") == pytest.approx(0.2, rel=0.05)


@pytest.mark.parametrize("part", [0.05, 0.3, 0.6])
def test_it_begins_as_stiff_as_the_cubic_law(part: float) -> None:
    cubic, amplitude = 200.0, 0.03
    turn = np.linspace(0.0, 2.0 * pi, 20001)[:-1]
    q = amplitude * np.cos(turn)
    share = _as_stiff(cubic, amplitude, part)
    over = np.maximum(q - part * amplitude, 0.0)
    assert np.mean(share * over * np.cos(turn)) == pytest.approx(
        np.mean(cubic * q**3 * np.cos(turn)), rel=1e-3
    )


def _without_joint(data: Measured) -> Measured:
    nothing = np.full(data.cycles, np.nan)
    return replace(data, position=nothing, velocity=nothing)


@pytest.mark.slow
@pytest.mark.parametrize("of_the_joint", [True, False])
def test_images_that_follow_the_joint_are_no_walk(of_the_joint: bool) -> None:
    """A joint that is slower one way leaves the arm ever further off. No sensor of its own shows it."""
    data = measured(20.0, 5)
    if of_the_joint:
        told = replace(data, command=np.where(data.command < 0.0, 1.0 / 0.98, 1.0) * data.command)
    else:
        steps = np.random.default_rng(3).normal(0.0, 0.1, len(data.frames.displacement_px))
        frames = replace(data.frames, displacement_px=data.frames.displacement_px + np.cumsum(steps))
        told = replace(data, frames=frames)
    before = fitted(_without_joint(told))
    first = Candidate(FORM.id, before, 0.0, 1.0, {}, form=FORM.name, merit=100.0)
    rival = rival_law(first, before, SPLIT)
    assert (rival is not None) == of_the_joint
    if rival is not None:
        assert rival.group is DRIVE
        assert rival.merit > first.merit
