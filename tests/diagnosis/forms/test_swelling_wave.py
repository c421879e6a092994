"""A wave's terms and its phasor tell the same."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stillarm.diagnosis.forms.swelling_wave import phasor_of, wave_columns

SECONDS = 8.0
TIME = np.arange(0.0, SECONDS, 0.01)


@given(seed=st.integers(0, 2**32 - 1), hz=st.floats(0.2, 20.0))
def test_the_phasor_is_the_wave_s(seed: int, hz: float) -> None:
    columns = wave_columns(TIME, SECONDS, hz)
    amounts = np.random.default_rng(seed).normal(size=columns.shape[1])
    turned = phasor_of(amounts, TIME, SECONDS) * np.exp(2j * np.pi * hz * TIME)
    assert np.allclose(columns @ amounts, turned.real)


def test_a_swell_of_seven_seconds_is_followed_to_one_percent() -> None:
    swell = np.sin(2.0 * np.pi * TIME / 7.0)
    columns = wave_columns(TIME, SECONDS, 5.0)
    wave = swell * np.cos(2.0 * np.pi * 5.0 * TIME)
    left = wave - columns @ np.linalg.lstsq(columns, wave, rcond=None)[0]
    assert np.std(left) < 0.01 * np.std(wave)
