"""The baseline's fit finds an arm whose frequency is far from the model's, and impacts that go beyond the sensor's
range, and says nothing else of them."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.events.impacts import fit_with_impacts
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.search.baseline import (
    _at_the_seen_frequency,
    _left_by_a_wrong_start,
    _likelier,
    _steady_with_impacts_of,
    _struck_along,
    fitted_baseline,
)
from stillarm.diagnosis.sensors.accelerometer_faults import ceiling_of
from tests.fixtures.synthetic import MODEL, measured

LIMIT_M_S2 = 8.0


@pytest.mark.slow
@pytest.mark.parametrize("hz", [2.6, 3.1])
def test_a_frequency_far_off_is_fitted(hz: float) -> None:
    world = World(measured(20.0, 5, {"modes.0.frequency_hz": hz}), MODEL)
    found = _at_the_seen_frequency(world, interleaved(20.0))
    assert found.value("modes.0.frequency_hz") == pytest.approx(hz, rel=1e-3)
    assert found.value("modes.0.damping_ratio") == pytest.approx(MODEL.arm.modes[0].damping_ratio, rel=0.1)


def test_one_frequency_beside_a_course_is_no_less_likely_than_the_steady_fit() -> None:
    """It is begun from where the course begins: from there this arm's mode is fitted away."""
    split, hz = interleaved(9.0), 1.7
    world = World(measured(9.0, 3, {"modes.0.frequency_hz": hz}), MODEL)
    data, names = make_data(world, split), world.baseline_names()
    begun = world.space.with_values(world.space.vector(), {"modes.0.frequency_hz": hz})
    steady = fit(data, begun, names)
    seen = replace(fit(data, world.space.vector(), names, iterations=0), train_log_likelihood=np.inf)
    found = _steady_with_impacts_of(seen, steady, split, ("arm.onset_s", "arm.frequency_ratio"))
    assert found is not None
    assert found.value("modes.0.frequency_hz") == pytest.approx(hz, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("drifts", [True, False])
def test_impacts_are_sought_along_a_course_only_where_one_frequency_does_worse(drifts: bool) -> None:
    split, rate, struck = interleaved(16.0), -0.01, 7300
    course = {"arm.frequency_rate_per_s": rate if drifts else 0.0}
    data = measured(16.0, 3, {"jump.1.0.v": 0.4, **course}, impacts=(struck,))
    world = World(data, MODEL)
    steady = fit_with_impacts(world, split)
    hz = MODEL.arm.modes[0].frequency_hz
    found, plain = _struck_along(
        {"modes.0.frequency_hz": hz, "arm.frequency_rate_per_s": rate}, steady, world, split
    )
    assert (plain is None) == drifts
    if drifts:
        assert found.world.impacts == pytest.approx((struck,), abs=15)


def test_a_likelier_fit_with_fewer_impacts_is_the_baseline() -> None:
    split = interleaved(9.0)
    world = World(measured(9.0, 3), MODEL)
    best = fit(make_data(world, split), world.space.vector(), world.baseline_names())
    made_up = world.changed(impacts=(2000,))
    far = made_up.space.with_values(made_up.space.vector(), {"modes.0.frequency_hz": 3.4})
    steady = fit(make_data(made_up, split), far, made_up.baseline_names(), iterations=0)
    found = _likelier([best], steady, split)
    assert found is not None
    assert found.train_log_likelihood >= best.train_log_likelihood
    assert _likelier([steady], best, split) is None
    assert _likelier([], best, split) is None


@pytest.mark.slow
@pytest.mark.parametrize("stated_m_s2", [LIMIT_M_S2, 20.0], ids=["stated", "unknown"])
def test_an_impact_beyond_the_sensor_s_limit_is_found_where_it_was(stated_m_s2: float) -> None:
    """A second passes until the sensor shows all of the vibration again."""
    struck = 7300
    sensor = msgspec.structs.replace(MODEL.accelerometer, range_m_s2=stated_m_s2)
    model = msgspec.structs.replace(MODEL, accelerometer=sensor)
    data = measured(12.0, 5, {"jump.1.0.v": 3.0}, impacts=(struck,), model=model)
    shown = np.clip(data.acceleration, -LIMIT_M_S2, LIMIT_M_S2)
    assert ceiling_of(shown, sensor.noise_std_m_s2) is not None
    found = fitted_baseline(World(replace(data, acceleration=shown), model), interleaved(12.0))
    assert len(found.world.impacts) == 1
    assert found.world.impacts[0] == pytest.approx(struck, abs=10)


@pytest.mark.parametrize(
    ("hz", "level", "impact_cycles", "again"),
    [
        pytest.param(1.013, 5.0, (4300,), True, id="far off, and much left"),
        pytest.param(1.0, 5.0, (4300,), False, id="where its impacts were sought"),
        pytest.param(1.013, 1.0, (4300,), False, id="far off, and nothing left"),
        pytest.param(1.013, 5.0, (), False, id="without impacts"),
    ],
)
def test_impacts_are_sought_again_where_a_wrong_frequency_found_them(
    hz: float, level: float, impact_cycles: tuple[int, ...], again: bool
) -> None:
    world = World(measured(9.0, 3, {}, impacts=impact_cycles), MODEL, impacts=impact_cycles)
    found = fit(
        make_data(world, interleaved(9.0)), world.space.vector(), world.baseline_names(), iterations=1
    )
    name = "modes.0.frequency_hz"
    vector = world.space.with_values(found.vector, {name: hz * world.space[name].start})
    sigma = found.sigma | {"acceleration": level * MODEL.accelerometer.noise_std_m_s2}
    assert _left_by_a_wrong_start(replace(found, vector=vector, sigma=sigma)) is again
