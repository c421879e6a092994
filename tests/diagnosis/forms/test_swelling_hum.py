"""A hum that swells is followed, with its frequency and mean size; where no line is the mains' none is sought."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.common.causes import CAUSES
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.forms.swelling_hum import FORM
from tests.fixtures.synthetic import NOISE, fitted, measured, with_form

SECONDS, HZ, SIZE = 20.0, 50.03, 4.0


def with_wave(hz: float) -> Measured:
    plain = measured(SECONDS, 1)
    time = np.arange(plain.cycles) * plain.cycle_s
    swell = SIZE * (1.0 + 0.4 * np.sin(2.0 * np.pi * time / 7.0))
    return replace(plain, acceleration=plain.acceleration + swell * np.sin(2.0 * np.pi * hz * time))


@pytest.mark.slow
def test_a_swell_is_followed_to_the_noise() -> None:
    plain = fitted(with_wave(HZ))
    found = with_form(FORM, plain)
    left = float(np.nanstd(found.residuals["acceleration"]))
    assert left < 1.05 * NOISE["acceleration"] < float(np.nanstd(plain.residuals["acceleration"]))
    told = FORM.cause.parameters_of(found)
    assert set(told) <= {parameter.name for parameter in CAUSES["mains_hum"].parameters}
    assert told["frequency_hz"][0] == pytest.approx(HZ, abs=1.0 / SECONDS)
    assert told["amplitude_m_s2"][0] == pytest.approx(SIZE, rel=0.1)


def test_a_line_that_is_no_mains_is_no_hum() -> None:
    assert FORM.added is not None
    assert FORM.added(fitted(with_wave(72.0))) == ()
