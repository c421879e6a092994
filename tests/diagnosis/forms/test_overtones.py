"""A periodic force that is no sine is followed, with its frequency and size; a sine is left to the declared form."""

import numpy as np
import pytest

from stillarm.common.causes import CAUSES
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.forms.overtones import FORM
from tests.fixtures.forced_arm import forced
from tests.fixtures.synthetic import NOISE, fitted, with_form

SECONDS, HZ, SIZE = 20.0, 1.713, 0.5


def pushed(overtone: float) -> Measured:
    """The arm of a recording under a wave with an overtone."""

    def force(t: float) -> float:
        phase = 2.0 * np.pi * HZ * t
        return float(SIZE * (np.sin(phase + 0.4) + overtone * np.sin(2.0 * phase + 1.1)))

    return forced(force, SECONDS)


@pytest.mark.slow
def test_a_wave_that_is_no_sine_is_followed_to_the_noise() -> None:
    plain = fitted(pushed(0.4))
    found = with_form(FORM, plain)
    left = float(np.nanstd(found.residuals["acceleration"]))
    assert left < 1.1 * NOISE["acceleration"] < float(np.nanstd(plain.residuals["acceleration"]))
    told = FORM.cause.parameters_of(found)
    assert set(told) <= {parameter.name for parameter in CAUSES["periodic_disturbance"].parameters}
    assert told["frequency_hz"][0] == pytest.approx(HZ, abs=0.003)
    assert told["amplitude_m_s2"][0] == pytest.approx(SIZE, rel=0.05)


@pytest.mark.slow
def test_a_sine_has_no_overtones() -> None:
    assert FORM.added is not None
    assert FORM.added(fitted(pushed(0.0))) == ()
