"""Mains hum on the accelerometer."""

from dataclasses import replace

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import (
    Cause,
    Context,
    Form,
    Trial,
    Values,
    free_of,
    has,
    plain,
    size_of_wave,
)

_HZ = "accelerometer.hum_hz"
_FIRST = ("accelerometer.hum_sin", "accelerometer.hum_cos")
_THIRD = ("accelerometer.hum_third_sin", "accelerometer.hum_third_cos")


def _trials(context: Context) -> list[Trial]:
    peaks = {f for channel in ("acceleration",) for f in context.peaks_hz.get(channel, ())}
    return [Trial({_HZ: f}, tuple({one: 0.01} for one in _FIRST)) for f in sorted(peaks)]


def _trials_with_third(context: Context) -> list[Trial]:
    """Of the mains' lines that have one at three times their frequency: a loaded mains is flat at its tops."""
    peaks = context.peaks_hz.get("acceleration", ())
    third = [
        f for f in peaks if _among(f, _FIRST_HZ) and any(abs(one / (3.0 * f) - 1.0) < _AT for one in peaks)
    ]
    return [Trial({_HZ: f}, tuple({one: 0.01} for one in (*_FIRST, *_THIRD))) for f in third]


def _values(fit: Fit) -> Values:
    found = plain(fit, frequency_hz=_HZ)
    found["amplitude_m_s2"] = size_of_wave(fit, *_FIRST)
    return found


_FIRST_HZ, _AT = (50.0, 60.0), 0.003  # of the mains; of three times that, to which a peak tells a line
_MAINS_HZ = (50.0, 60.0, 100.0, 120.0, 150.0, 180.0)  # the two mains, their second and third harmonics


_RARE_HZ = (16.7, 33.3, 400.0)  # railways, ships and aircraft


def of_the_mains(hz: float) -> bool:
    """Whether a frequency is that of a house's mains, or of a harmonic of one, to 1.5 %."""
    return _among(hz, _MAINS_HZ)


def _among(hz: float, usual_hz: tuple[float, ...]) -> bool:
    return any(abs(hz / one - 1.0) < 0.015 for one in usual_hz)


def _unusual(fit: Fit) -> float:
    hz = fit.value(_HZ)
    if of_the_mains(hz):
        return 0.0
    # a machine may run at any frequency: at a rare mains' it is a little likelier
    return 1.5 if _among(hz, _RARE_HZ) else 6.0


CAUSE = Cause(
    id="mains_hum",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of(_HZ, *_FIRST),
    parameters_of=_values,
    prior_penalty=_unusual,
)
WITH_THIRD = Form(
    replace(CAUSE, trials=_trials_with_third, free=free_of(_HZ, *_FIRST, *_THIRD)), "with its third harmonic"
)
