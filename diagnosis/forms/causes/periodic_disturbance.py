"""A periodic force on the arm."""

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import (
    Cause,
    Context,
    Trial,
    Values,
    arm_moves,
    free_of,
    plain,
    size_of_wave,
)
from stillarm.diagnosis.forms.causes.mains_hum import of_the_mains


def _trials(context: Context) -> list[Trial]:
    peaks = {
        f
        for channel in ("acceleration", "displacement", "deflection")
        for f in context.peaks_hz.get(channel, ())
    }
    return [
        Trial({"arm.periodic_hz": f}, ({"arm.periodic_sin": 0.01}, {"arm.periodic_cos": 0.01}))
        for f in sorted(peaks)
    ]


def _values(fit: Fit) -> Values:
    found = plain(fit, frequency_hz="arm.periodic_hz")
    found["amplitude_m_s2"] = size_of_wave(fit, "arm.periodic_sin", "arm.periodic_cos")
    return found


CAUSE = Cause(
    id="periodic_disturbance",
    needs=arm_moves,
    trials=_trials,
    free=free_of("arm.periodic_hz", "arm.periodic_sin", "arm.periodic_cos"),
    parameters_of=_values,
    prior_penalty=lambda fit: 4.0 if of_the_mains(fit.value("arm.periodic_hz")) else 0.0,
)
