"""When what a cause mends is large enough to be told."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.physics.computing import OutOfTime
from stillarm.diagnosis.physics.space import Added
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.convincing import (
    FORETOLD_NATS,
    LEAST_OF_NOISE,
    convinces,
    is_of_free_form,
    is_too_little,
    size_in_noise,
)
from tests.fixtures.synthetic import NOISE, fitted, measured, with_rest

SPLIT = interleaved(6.0)
BLOCKS = len(SPLIT.held)
FOUND = np.full(BLOCKS, FORETOLD_NATS)


@pytest.fixture(scope="module")
def plain() -> Fit:
    return fitted(measured(6.0, 1))


def test_what_is_mended_is_measured_by_the_noise(plain: Fit) -> None:
    before = with_rest(plain, "acceleration", 2.0 * NOISE["acceleration"])
    assert size_in_noise(before, plain, SPLIT) == pytest.approx(2.0, rel=0.15)


@pytest.mark.parametrize(("of_step", "counts"), [(0.2, False), (1.0, True)])
def test_what_rounding_makes_is_no_size(
    plain: Fit, monkeypatch: pytest.MonkeyPatch, of_step: float, counts: bool
) -> None:
    """A fit may take as much of an encoder's steps as their rounding is off."""
    step = 2e-3
    monkeypatch.setattr(plain.world, "resolution", lambda name: step if name == "joint_position" else 0.0)
    before = with_rest(plain, "joint_position", of_step * step)
    assert (size_in_noise(before, plain, SPLIT) > 0.1) == counts


@pytest.mark.parametrize(("of_noise", "told"), [(0.3, False), (0.7, True)])
def test_a_free_course_is_told_where_it_matters(plain: Fit, of_noise: float, told: bool) -> None:
    """A course of any shape takes a part of whatever else a model lacks."""
    before = with_rest(plain, "acceleration", of_noise * NOISE["acceleration"])
    column = np.ones((len(plain.residuals["acceleration"]), 1))
    course = plain.world.changed(added=(Added("course", {"acceleration": column}, 1.0),))
    one = Candidate(
        "accelerometer_bias_drift",
        replace(plain, world=course),
        0.0,
        0.0,
        {},
        merit=2.0 * CONVINCING_NATS,
        nats=FOUND,
    )
    assert is_of_free_form(one, before)
    assert convinces(one, before, SPLIT, beside=False) is told
    assert is_too_little(one, before, SPLIT) is not told


@pytest.mark.parametrize(
    ("times", "of_noise", "told"), [(1.0, 0.3, False), (1.0, 0.7, True), (1.5, 0.3, True), (2.0, 0.3, False)]
)
def test_a_small_force_at_a_modes_own_frequency_is_not_told(
    plain: Fit, times: float, of_noise: float, told: bool
) -> None:
    """The resonance makes other small errors of the model look like that."""
    before = with_rest(plain, "acceleration", of_noise * NOISE["acceleration"])
    hz = times * plain.value("modes.0.frequency_hz")
    values = {"frequency_hz": (hz, 0.01), "amplitude_m_s2": (0.01, 0.001)}
    one = Candidate("periodic_disturbance", plain, 0.0, 0.0, values, merit=2.0 * CONVINCING_NATS, nats=FOUND)
    assert convinces(one, before, SPLIT, beside=False) is told
    assert is_too_little(one, before, SPLIT) is (times != 1.5 and not told)


@pytest.mark.parametrize(
    ("leaks_m_s2_per_rad", "merit", "beside", "told"),
    [(5.0, 50.0, True, True), (5.0, 1.0, True, False), (0.1, 50.0, True, False), (5.0, 50.0, False, False)],
)
def test_what_another_finding_took_over_is_told_by_its_own_size(
    leaks_m_s2_per_rad: float, merit: float, beside: bool, told: bool
) -> None:
    """A course of the bias follows an axis that leans: what is left to mend is little, whatever the leaning is."""
    gain = "accelerometer.gravity_m_s2_per_rad"
    leaning = fitted(measured(6.0, 1, {gain: leaks_m_s2_per_rad}), gain)
    one = Candidate("gravity_leakage", leaning, 0.0, 0.0, {}, free=(gain,), merit=merit, nats=FOUND)
    last = with_rest(leaning, "acceleration", 0.1 * NOISE["acceleration"])
    assert convinces(one, last, SPLIT, beside) is told


def test_what_no_time_is_left_to_size_does_not_convince(plain: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    def late(*_: object) -> None:
        raise OutOfTime

    gain = "accelerometer.gravity_m_s2_per_rad"
    one = Candidate("gravity_leakage", plain, 0.0, 0.0, {}, free=(gain,), merit=50.0, nats=FOUND)
    monkeypatch.setattr(plain.world, "predict", late)
    assert not convinces(one, plain, SPLIT, beside=True)


@pytest.mark.parametrize(("held_out", "told"), [(FORETOLD_NATS, True), (0.0, False)])
def test_what_foretells_nothing_where_it_was_not_fitted_is_not_told(
    plain: Fit, held_out: float, told: bool
) -> None:
    before = with_rest(plain, "acceleration", 2.0 * NOISE["acceleration"])
    nats = np.where(SPLIT.held, held_out, FORETOLD_NATS)
    one = Candidate("cubic_stiffness", plain, 0.0, 0.0, {}, merit=2.0 * CONVINCING_NATS, nats=nats)
    assert convinces(one, before, SPLIT, beside=False) is told


@pytest.mark.parametrize(("blocks", "told"), [(BLOCKS, True), (2, False)])
def test_a_mode_that_shows_at_one_event_alone_is_that_events(plain: Fit, blocks: int, told: bool) -> None:
    before = with_rest(plain, "acceleration", 2.0 * NOISE["acceleration"])
    nats = np.zeros(BLOCKS)
    nats[:blocks] = 60.0 / blocks
    one = Candidate("second_bending_mode", plain, 0.0, 0.0, {}, merit=50.0, nats=nats)
    assert convinces(one, before, SPLIT, beside=False) is told


@pytest.mark.parametrize(("steps", "told"), [(True, True), (False, False)])
def test_of_what_lasts_in_the_arrivals_a_step_counts_and_a_drift_does_not(
    plain: Fit, steps: bool, told: bool
) -> None:
    """A delay that wanders looks like a drift, whatever is wrong."""
    shown = plain.predicted.channels["arrival"]
    along = np.linspace(-1.0, 1.0, len(shown))
    later = 8.0 * plain.sigma["arrival"] * (np.sign(along) if steps else along)
    arrivals = {**plain.predicted.channels, "arrival": shown + later}
    after = replace(plain, predicted=replace(plain.predicted, channels=arrivals))
    assert (size_in_noise(plain, after, SPLIT) > LEAST_OF_NOISE) is told


@pytest.mark.parametrize(("of_stated", "told"), [(1.2, False), (2.0, True)])
def test_a_drift_that_goes_further_than_the_delay_is_stated_to_counts(
    plain: Fit, of_stated: float, told: bool
) -> None:
    shown = plain.predicted.channels["arrival"]
    along = np.linspace(-1.0, 1.0, len(shown)) * 3.0**0.5  # its deviation is 1
    drift = of_stated * plain.world.model.timing.capture_delay_std_s * along
    arrivals = {**plain.predicted.channels, "arrival": shown + drift}
    after = replace(plain, predicted=replace(plain.predicted, channels=arrivals))
    assert (size_in_noise(plain, after, SPLIT) > LEAST_OF_NOISE) is told
