"""A hum of a loaded mains, which has a third harmonic, that sets in on the way."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.forms.catalogue import forms
from stillarm.diagnosis.forms.cause import Context
from stillarm.diagnosis.forms.causes.mains_hum import WITH_THIRD
from stillarm.diagnosis.report.extended_model import effects_of
from stillarm.diagnosis.search.candidates import Found
from stillarm.diagnosis.search.comparison import compared
from tests.fixtures.synthetic import fitted, measured

HZ, SIZE, THIRD, BEGIN_S = 50.02, 4.0, 1.6, 7.3
PHASE, PHASE_OF_THIRD = 0.4, 1.9


def with_hum() -> Measured:
    plain = measured(20.0, 1)
    time = np.arange(plain.cycles) * plain.cycle_s
    phase = 2.0 * np.pi * HZ * time
    hum = SIZE * np.sin(phase + PHASE) + THIRD * np.sin(3.0 * phase + PHASE_OF_THIRD)
    return replace(plain, acceleration=plain.acceleration + np.where(time >= BEGIN_S, hum, 0.0))


@pytest.mark.slow
def test_its_harmonic_and_its_onset_are_found_together() -> None:
    """A periodic force with its overtones would tell the harmonic, and a plain hum the onset."""
    last = fitted(with_hum())
    tried = [one for one in forms(last.world) if one.id in ("mains_hum", "periodic_disturbance")]
    _, candidates = compared(last, tried, interleaved(20.0), Found(last, last))
    best, others = candidates[0], [one for one in candidates if one.form != candidates[0].form]
    assert (best.cause, best.form) == ("mains_hum", "with its third harmonic, from an onset")
    assert best.merit > others[0].merit + 1000.0  # what the harmonic is worth, a quarter of the whole
    assert best.begins_s == pytest.approx(BEGIN_S, abs=0.002)
    first, third = effects_of(best, best.fit)
    assert first["frequency_hz"] == pytest.approx(HZ, abs=0.002)
    assert first["amplitude_m_s2"] == pytest.approx(SIZE, rel=0.02)
    assert third["frequency_hz"] == pytest.approx(3.0 * HZ, abs=0.006)
    assert third["amplitude_m_s2"] == pytest.approx(THIRD, rel=0.03)
    assert first["phase_rad"] == pytest.approx(PHASE, abs=0.05)
    assert third["phase_rad"] == pytest.approx(PHASE_OF_THIRD, abs=0.1)


@pytest.mark.parametrize(
    ("peaks", "tried"), [((50.0, 150.02), 1), ((50.0, 147.0), 0), ((40.0, 120.0), 0), ((50.0,), 0)]
)
def test_a_harmonic_is_tried_where_there_is_a_line(peaks: tuple[float, ...], tried: int) -> None:
    context = Context(fitted(measured(6.0, 1)), {"acceleration": peaks})
    assert len(WITH_THIRD.cause.trials(context)) == tried
