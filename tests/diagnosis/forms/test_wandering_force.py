"""A periodic force that wanders is followed, with its frequency and size; one that stays as it is, is left to the
declared form, and the arm's own ringing to the arm."""

import numpy as np
import pytest

from stillarm.common.causes import CAUSES
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.forms.wandering_force import FORM
from tests.fixtures.forced_arm import forced
from tests.fixtures.synthetic import NOISE, fitted, with_form

SECONDS, HZ, SIZE = 20.0, 1.313, 0.8


def wandering(by_rad: float, hz: float = HZ) -> Measured:
    """The arm of a recording under a wave whose phase, and as much its size, swing."""

    def force(t: float) -> float:
        size = SIZE * (1.0 + 0.3 * by_rad * np.sin(2.0 * np.pi * t / 13.0))
        return float(size * np.sin(2.0 * np.pi * hz * t + by_rad * np.sin(2.0 * np.pi * t / 9.0)))

    return forced(force, SECONDS)


@pytest.mark.slow
def test_a_force_that_wanders_is_followed_to_the_noise() -> None:
    plain = fitted(wandering(0.9))
    found = with_form(FORM, plain)
    left = {name: float(np.nanstd(found.residuals[name])) for name in ("acceleration", "displacement")}
    assert left["acceleration"] < 1.1 * NOISE["acceleration"]
    assert left["displacement"] < 0.1 * float(np.nanstd(plain.residuals["displacement"]))
    told = FORM.cause.parameters_of(found)
    assert set(told) <= {parameter.name for parameter in CAUSES["periodic_disturbance"].parameters}
    assert told["frequency_hz"][0] == pytest.approx(HZ, abs=0.02)
    assert told["amplitude_m_s2"][0] == pytest.approx(SIZE, rel=0.15)


@pytest.mark.slow
def test_a_force_that_stays_as_it_is_does_not_wander() -> None:
    assert FORM.added is not None
    assert FORM.added(fitted(wandering(0.0))) == ()


@pytest.mark.slow
@pytest.mark.parametrize("of_the_arm", [1.0, 2.0])
def test_near_what_the_arm_does_of_itself_no_force_is_sought(of_the_arm: float) -> None:
    plain = fitted(wandering(0.9))
    hz = of_the_arm * plain.value("modes.0.frequency_hz") * 1.05
    near = fitted(wandering(0.9, hz))
    assert FORM.added is not None
    assert all(abs(one.hz / hz - 1.0) > 0.09 for one in FORM.added(near))
