"""A stiffness that drifts."""

from stillarm.diagnosis.events.frequency_course import shares
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import (
    Cause,
    Context,
    Trial,
    Values,
    arm_moves,
    of_the_modes,
    share_of,
)


def _trials(context: Context) -> list[Trial]:
    turn = 1.0 / (context.value("modes.0.frequency_hz") * context.world.measured.duration_s**2)
    name = "arm.frequency_rate_per_s"
    return [
        *(
            Trial(others, ({name: context.declared(name) + part * turn},))
            for others in shares(context.world)
            for part in (0.02, 0.5, -0.5, 2.0, -2.0)
        ),
        *context.along_a_course("stiffness_drift", name),
    ]


def _values(fit: Fit) -> Values:
    name = "arm.frequency_rate_per_s"
    f = fit.value("modes.0.frequency_hz")
    return {"frequency_rate_hz_per_s": (f * fit.value(name), f * fit.std.get(name, 0.0))} | share_of(fit)


CAUSE = Cause(
    id="stiffness_drift",
    needs=arm_moves,
    trials=_trials,
    free=of_the_modes("arm.frequency_rate_per_s"),
    parameters_of=_values,
)
