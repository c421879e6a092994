"""The input of a pair between its samples."""

import numpy as np
import pytest

from stillarm.diagnosis.physics.sampled_force import upsampled


@pytest.mark.parametrize("periods", [3.0, 17.3, 60.0])
def test_a_sampled_wave_goes_on_between_its_samples(periods: float) -> None:
    n, factor = 400, 4
    fine_at = np.arange(factor * n + 1) / (factor * n)
    wave = np.sin(2.0 * np.pi * periods * fine_at + 0.4)
    found = upsampled(wave[:-1:factor], factor)
    assert found.shape == (factor * n + 1,)
    assert np.allclose(found[:-1:factor], wave[:-1:factor], atol=1e-9)
    inner = slice(40 * factor, -40 * factor)  # the ends are mirrored, and a wave that is cut off is not
    assert np.max(np.abs(found[inner] - wave[inner])) < 0.01
