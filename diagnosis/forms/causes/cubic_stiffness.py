"""A stiffness that grows or falls with deflection."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, arm_moves, free_of, plain


def _trials(context: Context) -> list[Trial]:
    unit = 1.0 / context.amplitude_m**2
    name = "arm.cubic_per_m2"
    known = context.declared(name)
    return [
        *(Trial({}, ({name: known + share * unit},)) for share in (0.003, 0.03, -0.03, 0.2, -0.2)),
        *context.along_a_course("cubic_stiffness", name),
    ]


CAUSE = Cause(
    id="cubic_stiffness",
    needs=arm_moves,
    trials=_trials,
    free=free_of("arm.cubic_per_m2"),
    parameters_of=lambda fit: plain(fit, coefficient_per_m2="arm.cubic_per_m2"),
)
