"""Damping by the square of the speed."""

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, arm_moves, free_of, plain


def _trials(context: Context) -> list[Trial]:
    known = context.declared("arm.quadratic_per_m")
    return [
        Trial({}, ({"arm.quadratic_per_m": known + share / context.amplitude_m},), one_sided=known == 0.0)
        for share in (0.002, 0.02, 0.1)
    ]


CAUSE = Cause(
    id="quadratic_damping",
    needs=arm_moves,
    trials=_trials,
    free=free_of("arm.quadratic_per_m"),
    parameters_of=lambda fit: plain(fit, coefficient_per_m="arm.quadratic_per_m"),
)
