"""Which free terms a name is held against."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.free_terms import beside_the_others, best_free
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.forms.courses import imaged
from stillarm.diagnosis.forms.freeform import Free, Group, groups
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.candidates import Candidate
from tests.fixtures.synthetic import MODEL, fitted, measured

SPLIT = interleaved(20.0)


@pytest.fixture(scope="module")
def arm() -> Fit:
    return fitted(measured(20.0, 3))


@pytest.mark.slow
def test_free_terms_count_where_a_rest_matters_or_where_the_finding_shows(arm: Fit) -> None:
    """A vibration in the acceleration alone, by less than anyone would act on."""
    name = "acceleration"
    ringing = 0.3 * arm.sigma[name] * np.sin(2.0 * np.pi * 22.0 * arm.world.cycle_times)
    channels = {**arm.predicted.channels, name: arm.predicted.channels[name] - ringing}
    rung = replace(
        arm,
        residuals={**arm.residuals, name: arm.residuals[name] + ringing},
        predicted=replace(arm.predicted, channels=channels),
    )
    assert best_free(rung, SPLIT) is None
    found = best_free(rung, SPLIT, (name,))
    assert found is not None and found.gains[name] > 12.0


def as_free(base: Fit, group: Group) -> Free:
    """A group on top of a baseline, whatever it is worth."""
    world = group.world(base)
    assert world is not None
    names = (*base.free, *world.added[-1].amounts)
    return Free(group, 0.0, "displacement", fit(make_data(world, SPLIT), carried_over(base, world), names))


@pytest.mark.slow
def test_free_terms_in_the_place_of_one_of_two_causes_are_held_against_both() -> None:
    """A camera that turns with the joint, and a tracker that drifts: terms that say the same as the first are worth as
    much in its place, others are not, whatever they are worth by themselves."""
    turns, drifts = "camera.rotation_px_per_rad", "camera.rate_px_per_s"
    data = measured(20.0, 3, {turns: 60.0, drifts: 0.6})
    base, final = fitted(data, split=SPLIT), fitted(data, turns, drifts, split=SPLIT)
    first = candidate("camera_tilt_coupling", fitted(data, turns, split=SPLIT), turns)
    second = candidate("tracking_drift", final, drifts)

    def merit(group: Group) -> float:
        return beside_the_others(as_free(base, group), first, [second], final, SPLIT).merit

    by_angle = Group(
        "angle",
        "an image that moves with the joint",
        lambda one: {"displacement": imaged(one, one.predicted.motion.joint[:, 0])[:, None]},
    )
    bent = next(one for one in groups(()) if one.name == "image")
    assert merit(by_angle) == pytest.approx(first.merit, abs=6.0)
    world = World(data, MODEL, (9000,))  # an impact that the findings make needless
    struck = fit(make_data(world, SPLIT), world.space.vector(), world.baseline_names())
    free = beside_the_others(as_free(struck, by_angle), first, [second], final, SPLIT)
    assert free.merit == pytest.approx(first.merit, abs=6.0)
    assert merit(bent) < first.merit - 30.0


def candidate(cause: str, found: Fit, name: str) -> Candidate:
    return Candidate(cause, found, 100.0, 1.0, {}, free=(name,), merit=500.0)
