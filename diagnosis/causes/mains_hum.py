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


CAUSE = Cause(
    id="mains_hum",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.hum_hz", "accelerometer.hum_sin", "accelerometer.hum_cos"),
    parameters_of=_values,
)
