"""Dry friction in the arm."""

from stillarm.common.causes.declaration import Cause, size


def law(
    t: float, theta: float, omega: float, q: float, v: float, w: float, force_per_mass_m_s2: float
) -> float:
    """Largest dry friction, m/s^2."""
    return force_per_mass_m_s2


CAUSE = Cause(
    "coulomb_damping",
    "arm",
    name="dry friction in the arm",
    sees=(
        "the envelope of a ring-down falls along a straight line instead of fading out, and the arm "
        "stops off its rest position, held by the friction"
    ),
    equation="q_1'' = ... - force sign(q_1'); at rest it holds against as much",
    parameters=(size("force_per_mass_m_s2", "m/s^2", 100.0, 0.01, 0.05),),
    provoke="let the arm ring down freely, damping off, until it stands.",
    acts="friction",
    law=law,
)
