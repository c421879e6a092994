"""What convinced in a round beside the one that it took, refitted beside that one."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import carried_over, make_data
from stillarm.diagnosis.forms.catalogue import forms
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search import carried
from stillarm.diagnosis.search.begun import ground_of
from stillarm.diagnosis.search.candidates import Candidate, Found
from stillarm.diagnosis.search.carried import second_best
from tests.fixtures.synthetic import fitted, measured

SECONDS = 20.0
CAUSES = ("gravity_leakage", "cubic_stiffness", "tracking_drift", "lens_distortion")


def explained(values: dict[str, float]) -> Found:
    """What is found of these causes in a recording with these quantities."""
    return explain(fitted(measured(SECONDS, 5, values)), interleaved(SECONDS), only=CAUSES)


@pytest.mark.slow
@pytest.mark.parametrize(("cubic_per_m2", "compared"), [(3.0, set()), (10.0, {"gravity_leakage"})])
def test_where_the_second_best_explains_the_rest_no_other_form_is_compared_anew(
    cubic_per_m2: float, compared: set[str]
) -> None:
    """None at all where it had over half the merit of what was taken beside that, or else those of its sensor, in which
    the first dwarfed all others."""
    found = explained({"accelerometer.gravity_m_s2_per_rad": 5.0, "arm.cubic_per_m2": cubic_per_m2})
    assert {one.cause for one in found.findings} == {"gravity_leakage", "cubic_stiffness"}
    assert found.final.value("arm.cubic_per_m2") == pytest.approx(cubic_per_m2, rel=0.1)
    assert found.stages[1].taken is not None
    assert {one.cause.id for one in found.stages[1].screening} == compared


@pytest.mark.slow
def test_where_the_second_best_leave_something_all_forms_are_compared() -> None:
    """A hum is left, of a cause that is not looked for."""
    hum = {"accelerometer.hum_hz": 50.0, "accelerometer.hum_sin": 2.0}
    found = explained({"accelerometer.gravity_m_s2_per_rad": 5.0, "arm.cubic_per_m2": 10.0} | hum)
    assert found.findings
    assert found.stages[1].screening


@pytest.mark.slow
def test_an_onset_is_carried_over() -> None:
    """A clock that was set, beside a stiffness that grows, after which nothing else is left."""
    data = measured(SECONDS, 5, {"arm.cubic_per_m2": 30.0})
    late_s = np.where(data.frames.received_s > 11.0, 0.05, 0.0)
    data = replace(data, frames=replace(data.frames, received_s=data.frames.received_s + late_s))
    found = explain(fitted(data), interleaved(SECONDS), only=(*CAUSES, "clock_step"))
    assert {one.cause for one in found.findings} == {"cubic_stiffness", "clock_step"}
    assert found.final.value("timing.step_onset_s") == pytest.approx(11.0, abs=0.1)
    assert found.final.value("timing.step_s") == pytest.approx(0.05, abs=0.005)


def test_without_a_second_best_nothing_is_refitted() -> None:
    assert second_best(fitted(measured(2.0, 5)), [], (), interleaved(2.0)) == []


@pytest.mark.parametrize(("extra_modes", "behind_encoder"), [(1, False), (0, True)])
def test_what_was_taken_keeps_its_structure(
    extra_modes: int, behind_encoder: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mode of the arm, and play behind the encoder, that a rival's world did not have when it was fitted."""
    plain = fitted(measured(4.0, 5))
    world = plain.world.changed(extra_modes=extra_modes, behind_encoder=behind_encoder)
    last = fit(make_data(world, interleaved(4.0)), carried_over(plain, world), plain.free, iterations=0)
    hint = Candidate("cubic_stiffness", plain, 0.0, 1.0, {}, free=("arm.cubic_per_m2",))
    begun_in: list[World] = []
    monkeypatch.setattr(carried, "refitted", lambda ground, begun: begun_in.append(begun.world))
    carried.hinted(ground_of(last, interleaved(4.0)), hint, forms(last.world))
    assert [(one.extra_modes, one.behind_encoder) for one in begun_in] == [(extra_modes, behind_encoder)]
