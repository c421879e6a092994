"""Mains hum on the accelerometer."""

from diagnosis.cause import Cause, Context, Trial, Values, free_of, has, plain, size_of_wave
from diagnosis.fit import Fit


def _trials(context: Context) -> list[Trial]:
    peaks = {f for channel in ("acceleration",) for f in context.peaks_hz.get(channel, ())}
    return [
        Trial({"accelerometer.hum_hz": f}, ({"accelerometer.hum_sin": 0.01}, {"accelerometer.hum_cos": 0.01}))
        for f in sorted(peaks)
    ]


def _values(fit: Fit) -> Values:
    found = plain(fit, frequency_hz="accelerometer.hum_hz")
    found["amplitude_m_s2"] = size_of_wave(fit, "accelerometer.hum_sin", "accelerometer.hum_cos")
    return found


_MAINS_HZ = (50.0, 60.0, 100.0, 120.0, 150.0, 180.0, 16.7, 33.3, 400.0)


def of_the_mains(hz: float) -> bool:
    """Whether a frequency is that of a mains, or of a harmonic of one, to 1.5 %."""
    return any(abs(hz / mains - 1.0) < 0.015 for mains in _MAINS_HZ)


CAUSE = Cause(
    id="mains_hum",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.hum_hz", "accelerometer.hum_sin", "accelerometer.hum_cos"),
    parameters_of=_values,
    surprise=lambda fit: 0.0 if of_the_mains(fit.value("accelerometer.hum_hz")) else 6.0,
)
