"""Mains hum whose size and phase take a course of their own: a load on the mains swells, comes and goes.

f is the largest line of the residual near the mains' frequencies; the wave is that of swelling_wave.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.forms.cause import Form, Values, has
from stillarm.diagnosis.forms.causes.mains_hum import of_the_mains
from stillarm.diagnosis.forms.courses import group_of, of_terms
from stillarm.diagnosis.forms.swelling_wave import wave_columns
from stillarm.diagnosis.physics.space import Added

Array = NDArray[np.float64]

_GROUP = "hum"
_STD = 10.0  # of an amount, in deviations of what is left


def _line_hz(fit: Fit) -> float | None:
    """The largest line of the accelerometer's residual that is the mains'; None where there is none."""
    peaks = residual_peaks(fit).get("acceleration", ())
    return next((hz for hz in peaks if of_the_mains(hz)), None)


def _added(fit: Fit) -> tuple[Added, ...]:
    hz, sensor = _line_hz(fit), fit.channel("acceleration")
    if hz is None or sensor is None:
        return ()
    columns = wave_columns(fit.world.cycle_times, fit.world.measured.duration_s, hz)
    columns *= float(np.nanstd(sensor.residual))
    return (Added(_GROUP, {"acceleration": columns}, _STD, over_time=True),)


def _values(fit: Fit) -> Values:
    """The line's frequency and its mean size."""
    one = group_of(fit, _GROUP)
    wave = one.columns["acceleration"] @ np.array([fit.value(each) for each in one.amounts])
    hz = _line_hz_of(wave, fit.world.measured.cycle_s)
    return {"frequency_hz": (hz, 0.0), "amplitude_m_s2": (float(np.sqrt(2.0) * np.std(wave)), 0.0)}


def _line_hz_of(wave: Array, step_s: float) -> float:
    length = 4 * len(wave)
    power = np.abs(np.fft.rfft(wave * np.hanning(len(wave)), n=length))
    return float(np.argmax(power) / (length * step_s))


FORM: Form = of_terms("mains_hum", "that swells", has("acceleration"), _GROUP, _values, _added)
