"""The forms of each cause: their quantities exist, their parameters are the catalogue's, an onset is one more."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import slopes_of
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data
from stillarm.diagnosis.fitting.gains import gain_of
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.forms.catalogue import BEGINS, forms, from_an_onset
from stillarm.diagnosis.forms.cause import Context, Form
from stillarm.diagnosis.forms.causes import CAUSES
from stillarm.diagnosis.forms.courses import path_terms
from stillarm.diagnosis.physics.declared_effects import quantity_of
from stillarm.diagnosis.physics.quantities import MOST_DOWN, MOST_UP
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.begun import ground_of
from stillarm.diagnosis.search.refits import refitted
from stillarm.diagnosis.search.screen import variant
from stillarm.diagnosis.search.starts import begun_fits
from stillarm.diagnosis.search.whitened import Whitened
from tests.fixtures.synthetic import MODEL, fitted, measured

WORLD = World(measured(6.0, 1), MODEL)
# a hum, a walk, or a wave has to be there: test_swelling_hum.py, test_sensor_walk.py, test_delay_walk.py,
# test_overtones.py
ALL = [
    one for one in forms(WORLD) if one.name not in ("that swells", "as a random walk", "with its overtones")
]
NO_RATE = ("lens_distortion", "camera_tilt_coupling", "periodic_disturbance")
RATES = [one for one in ALL if one.added is not None and one.id not in NO_RATE]
COURSES = [one for one in RATES if one.name != "with the path travelled"]


def titled(one: Form) -> str:
    return f"{one.id} {one.name}".strip()


@pytest.fixture(scope="module")
def plain() -> Fit:
    """The baseline on data with nothing wrong."""
    return fitted(measured(6.0, 1))


def context_of(plain: Fit) -> Context:
    """With lines in the acceleration that some forms ask for."""
    return Context(plain, residual_peaks(plain) | {"acceleration": (7.0, 50.0, 150.0)})


def fit_of(one: Form, plain: Fit) -> Fit:
    """A fit with the form's terms, at the baseline."""
    world = plain.world.changed(added=one.added(plain)) if one.added else plain.world
    trials = one.cause.trials(context_of(plain))
    options = dict(trials[0].options) if trials else {}  # what the data do not ask for is not tried
    world = variant(world, options) if options else world
    start = carried_over(plain, world)
    return replace(plain, world=world, vector=start, predicted=world.predict(start), std={})


def test_every_cause_has_a_form_and_none_has_the_same_twice() -> None:
    assert {one.id for one in ALL} | {"modal_temperature_drift"} >= set(CAUSES)
    assert len({(one.id, one.name) for one in ALL}) == len(ALL)
    assert all(one.id in CATALOGUE for one in ALL)


def test_a_drift_that_levels_off_is_a_form_of_a_steady_one() -> None:
    assert "modal_temperature_drift" not in {one.id for one in ALL}
    assert {"", "that levels off"} <= {one.name for one in ALL if one.id == "stiffness_drift"}


@pytest.mark.slow
@pytest.mark.parametrize("one", ALL, ids=titled)
def test_its_quantities_exist_and_its_parameters_are_the_catalogues(one: Form, plain: Fit) -> None:
    found = fit_of(one, plain)
    place = found.world.space.place
    free = one.cause.free(found.world)
    assert free and all(name in place for name in free)
    for trial in one.cause.trials(context_of(plain)):
        for column in (trial.shape, *trial.columns):
            own = variant(found.world, dict(trial.options)).space.place if trial.options else place
            assert all(name in own for name in column)
    assert all(name in place for name in one.cause.settle)
    known = {parameter.name for parameter in CATALOGUE[one.id].parameters}
    told = one.cause.parameters_of(found)
    assert told and set(told) <= known


@pytest.mark.parametrize("one", [one for one in ALL if one.name and not one.added], ids=titled)
def test_a_further_form_moves_a_channel(one: Form, plain: Fit) -> None:
    base = plain.predicted.channels
    for trial in one.cause.trials(Context(plain, residual_peaks(plain))):
        values = {**trial.shape, **trial.columns[0]}
        shown = plain.world.predict(plain.world.space.with_values(plain.vector, values)).channels
        assert any(np.max(np.abs(np.nan_to_num(shown[name] - base[name]))) > 0.0 for name in base)


@pytest.mark.parametrize("one", ALL, ids=titled)
def test_from_an_onset_it_acts_as_before_and_begins_at_a_quantity_of_its_place(one: Form) -> None:
    later = from_an_onset(one)
    has_one = bool(one.added) or any("onset" in name for name in one.cause.settle)
    if has_one:
        assert later is None
    if later is None:
        return
    assert later.begins == BEGINS[CATALOGUE[one.id].place]
    assert later.begins in WORLD.space.place
    assert later.cause is one.cause and later.name.endswith("from an onset")
    assert from_an_onset(later) is None


@pytest.mark.slow
@pytest.mark.parametrize("one", [one for one in ALL if from_an_onset(one) is not None], ids=titled)
def test_what_begins_at_the_end_has_done_nothing(one: Form, plain: Fit) -> None:
    """And what begins in the middle has done something only from then on."""
    later = from_an_onset(one)
    assert later is not None and later.begins is not None
    found = fit_of(one, plain)
    trial = one.cause.trials(context_of(plain))[-1]
    world = found.world
    values = {**trial.shape, **trial.columns[0]}

    def shown(begins_s: float, changed: bool) -> dict[str, np.ndarray]:
        own = {**(values if changed else {}), str(later.begins): begins_s}
        return world.predict(world.space.with_values(found.vector, own)).channels

    before, never = shown(1e6, False), shown(1e6, True)
    half = shown(3.0, True)
    early = {
        name: (
            WORLD.cycle_times
            if len(before[name]) == WORLD.measured.cycles
            else WORLD.measured.frames.received_s
        )
        < 2.7
        for name in before
        if name != "arrival"
    }
    for name, mask in early.items():
        assert never[name] == pytest.approx(before[name], abs=1e-9, nan_ok=True), name
        assert half[name][mask] == pytest.approx(before[name][mask], abs=1e-9, nan_ok=True), name


@pytest.mark.parametrize("one", COURSES, ids=titled)
def test_the_rate_of_a_course_is_that_of_its_straight_line(one: Form, plain: Fit) -> None:
    """Amounts that rise evenly move the channel evenly in time; twice the amounts are twice the rate."""
    found = fit_of(one, plain)
    (group,) = one.added(plain)  # type: ignore[misc]
    many, duration = len(group.amounts), found.world.measured.duration_s
    walks = one.name == "that wanders"
    rates = []
    for rise in (1.0, 2.0):
        amounts = np.full(many, rise * duration / many) if walks else rise * np.linspace(0.0, duration, many)
        values = dict(zip(group.amounts, amounts.tolist(), strict=True))
        told = one.cause.parameters_of(
            replace(found, vector=found.world.space.with_values(found.vector, values))
        )
        rates.append(next(iter(told.values()))[0])
    assert rates[1] == pytest.approx(2.0 * rates[0])
    (channel,) = group.columns
    time = WORLD.cycle_times if channel == "acceleration" else WORLD.measured.frames.received_s
    course = group.columns[channel] @ amounts
    if one.id != "accelerometer_sensitivity_drift":  # of a reading that varies
        unit = np.mean(group.columns[channel].sum(axis=1)) if not walks else np.max(group.columns[channel])
        assert course == pytest.approx(2.0 * unit * time, abs=1e-6 * np.max(np.abs(course)))
        assert rates[0] == pytest.approx(unit, rel=1e-6)
    else:  # in shares of it
        assert rates[0] == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("one", RATES, ids=titled)
def test_a_course_comes_on_top_of_the_rate_that_is_declared(one: Form, plain: Fit) -> None:
    found = fit_of(one, plain)
    (parameter,) = one.cause.parameters_of(found)
    name = quantity_of(one.id, parameter)
    more = replace(
        found, vector=found.world.space.with_values(found.vector, {name: found.value(name) + 3e-4})
    )
    rates = [next(iter(one.cause.parameters_of(each).values()))[0] for each in (found, more)]
    assert rates[1] - rates[0] == pytest.approx(3e-4)


def test_the_mean_rate_of_an_exponential_drift_is_from_begin_to_end(plain: Fit) -> None:
    one = next(one for one in ALL if one.name == "that levels off")
    values = {
        "modal_temperature_drift.relative_change": -0.02,
        "modal_temperature_drift.time_constant_s": 2.0,
    }
    found = replace(plain, vector=plain.world.space.with_values(plain.vector, values))
    hz = plain.value("modes.0.frequency_hz")
    wanted = -0.02 * hz * (1.0 - np.exp(-6.0 / 2.0)) / 6.0
    assert one.cause.parameters_of(found)["frequency_rate_hz_per_s"][0] == pytest.approx(wanted, rel=1e-3)


def test_a_joint_that_nobody_drove_has_no_forms_of_its_drive() -> None:
    data = measured(6.0, 1)
    still = World(replace(data, command=np.zeros(6000), reference=np.zeros(6000)), MODEL)
    assert not [one for one in forms(still) if one.name and CATALOGUE[one.id].place == "drive"]


LIMITS = [
    ("drive.most_rad_s2", 6.0),
    ("drive.most_up_rad_s2", 6.0),
    ("drive.fastest_down_rad_s", 0.15),
    (MOST_UP, 3.0),
    (MOST_DOWN, 3.0),
]


@pytest.mark.slow
@pytest.mark.parametrize(("quantity", "limit"), LIMITS, ids=[name for name, _ in LIMITS])
def test_a_limit_where_there_was_none_is_fitted_from_its_trial(quantity: str, limit: float) -> None:
    """No share of the way from no limit to one is a limit: a fit that begins there never finds it."""
    last = fitted(measured(12.0, 3, {quantity: limit, "jump.0.0.q": 0.02}))
    own = [one for one in forms(last.world) if one.cause.free(last.world) == (quantity,)]
    begun, _ = begun_fits(Whitened(make_data(last.world, interleaved(12.0)), last, slopes_of(last)), own)
    values = [float(one.start[one.world.space.place[quantity]]) for one in begun]
    assert values and all(0.3 * limit < value < 3.0 * limit for value in values)
    ground = ground_of(last, interleaved(12.0))
    fits = [refitted(ground, one) for one in begun]
    best = max((one for one in fits if one is not None), key=lambda one: gain_of(one, last))
    assert best.value(quantity) == pytest.approx(limit, rel=0.15)


def test_a_camera_that_turns_with_the_joint_alone_is_fitted_with_its_size() -> None:
    data = measured(6.0, 1)
    split = interleaved(6.0)
    plain = fitted(data)
    joint = np.interp(
        plain.world.instants(plain.vector), plain.world.cycle_times, plain.predicted.motion.joint[:, 0]
    )
    frames = replace(data.frames, displacement_px=data.frames.displacement_px - 80.0 * joint)
    last = fitted(replace(data, frames=frames))
    (tilt,) = (one for one in ALL if one.name == "with the joint alone")
    begun, _ = begun_fits(Whitened(make_data(last.world, split), last, slopes_of(last)), [tilt])
    found = refitted(ground_of(last, split), begun[0])
    assert found is not None
    told, std = tilt.cause.parameters_of(found)["rotation_px_per_rad"]
    assert abs(told - 80.0) < max(4.0 * std, 4.0)


def test_the_path_that_tracking_strays_with_begins_where_the_tip_is(plain: Fit) -> None:
    motion = plain.predicted.motion
    elsewhere = replace(
        plain, predicted=replace(plain.predicted, moved=replace(motion, tip=motion.tip + 5.0))
    )
    (here,), (there,) = path_terms(plain), path_terms(elsewhere)
    assert there.columns["displacement"] == pytest.approx(here.columns["displacement"], abs=1e-9)
