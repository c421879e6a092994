"""Gravity by the sine of the sensor's angle, judged against g worked out here from the joint's angle."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.forms.tilted_sensor import FORM
from stillarm.diagnosis.physics.quantities import GRAVITY_COSINE, GRAVITY_SINE, GRAVITY_SLOPE
from tests.fixtures.synthetic import NOISE, fitted, measured

SECONDS, GRAVITY_M_S2 = 12.0, 9.81
REST_RAD = 0.6  # the sensor's angle to the horizontal where the joint's is zero


def tilted(of_slope: float) -> Measured:
    """What a sensor reads that feels gravity; of_slope: share of the tip's slope by which it turns."""
    plain = measured(SECONDS, 4)
    motion = fitted(plain).predicted.motion
    theta = motion.joint[:, 0]
    angle = theta + of_slope * (motion.tip_angle - theta)
    felt = GRAVITY_M_S2 * (np.sin(angle + REST_RAD) - np.sin(REST_RAD))
    return replace(plain, acceleration=plain.acceleration + felt)


@pytest.mark.slow
@pytest.mark.parametrize("of_slope", [1.0, 0.0])
def test_gravity_is_told_by_the_sine_wherever_the_sensor_sits(of_slope: float) -> None:
    data = tilted(of_slope)
    plain = fitted(data)
    start = plain.world.space.with_values(plain.vector, {GRAVITY_SINE: 5.0})
    free = (*plain.free, *FORM.cause.free(plain.world))
    found = fit(make_data(plain.world, interleaved(SECONDS)), start, free)
    assert float(np.nanstd(found.residuals["acceleration"])) < 1.05 * NOISE["acceleration"]
    assert found.value(GRAVITY_SLOPE) == pytest.approx(of_slope, abs=0.2)
    gain, std = FORM.cause.parameters_of(found)["gain_m_s2_per_rad"]
    assert gain == pytest.approx(GRAVITY_M_S2 * np.cos(REST_RAD), abs=max(4.0 * std, 0.1))
    cosine = pytest.approx(GRAVITY_M_S2 * np.sin(REST_RAD), abs=4.0 * found.std[GRAVITY_COSINE])
    assert found.value(GRAVITY_COSINE) == cosine


def test_a_sensor_without_gravity_reads_what_it_did() -> None:
    plain = fitted(measured(SECONDS, 4))
    world, at = plain.world, plain.world.space.place
    turned = plain.vector.copy()
    turned[at[GRAVITY_SLOPE]] = 0.0
    before, after = (world.predict(one).channels["acceleration"] for one in (plain.vector, turned))
    assert np.array_equal(before, after)


def test_the_gain_is_on_top_of_a_declared_one() -> None:
    plain = fitted(measured(SECONDS, 4))
    values = {"accelerometer.gravity_m_s2_per_rad": 2.0, GRAVITY_SINE: 3.0}
    both = replace(plain, vector=plain.world.space.with_values(plain.vector, values))
    assert FORM.cause.parameters_of(both)["gain_m_s2_per_rad"][0] == pytest.approx(5.0)
