"""What terms take away from white residuals is what least squares of all samples say; where the arm rings of itself."""

import numpy as np
import pytest

from stillarm.diagnosis.forms.force_terms import nats_taken, own_frequencies_hz, shown_of, steady_wave
from tests.fixtures.synthetic import fitted, measured


def test_the_first_terms_take_what_least_squares_take() -> None:
    plain = fitted(measured(8.0, 3))
    force = np.concatenate([steady_wave(plain, 1.3), steady_wave(plain, 4.1)], axis=1)
    columns = shown_of(plain, force)
    rows, rest = [], []
    for name, terms in columns.items():
        sensor = plain.channel(name)
        assert sensor is not None
        known = np.isfinite(sensor.residual)
        rows.append(terms[known] / plain.sigma[name])
        rest.append(sensor.residual[known] / plain.sigma[name])
    design, off = np.concatenate(rows), np.concatenate(rest)

    def taken(count: int) -> float:
        left = off - design[:, :count] @ np.linalg.lstsq(design[:, :count], off, rcond=None)[0]
        return 0.5 * float(off @ off - left @ left)

    assert nats_taken(plain, columns, 4, 8) == pytest.approx([taken(4), taken(8)], rel=1e-6)


def test_an_arm_rings_of_itself_at_its_modes_and_their_overtones() -> None:
    plain = fitted(measured(8.0, 3))
    hz = plain.value("modes.0.frequency_hz")
    assert own_frequencies_hz(plain) == pytest.approx([hz, 2.0 * hz, 3.0 * hz])
