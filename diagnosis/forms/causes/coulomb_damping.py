"""Dry friction in the arm."""

from math import pi

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, arm_moves, free_of, plain


def _trials(context: Context) -> list[Trial]:
    stiff = (2.0 * pi * context.value("modes.0.frequency_hz")) ** 2 * context.amplitude_m
    known = context.declared("arm.coulomb_m_s2")
    return [
        Trial({}, ({"arm.coulomb_m_s2": known + share * stiff},), one_sided=known == 0.0)
        for share in (0.001, 0.01, 0.04)
    ]


CAUSE = Cause(
    id="coulomb_damping",
    needs=arm_moves,
    trials=_trials,
    free=free_of("arm.coulomb_m_s2"),
    parameters_of=lambda fit: plain(fit, force_per_mass_m_s2="arm.coulomb_m_s2"),
)
