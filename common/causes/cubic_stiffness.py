"""A stiffness that changes with the deflection."""

from stillarm.common.causes.declaration import Cause, size


def law(
    t: float, theta: float, omega: float, q: float, v: float, w: float, coefficient_per_m2: float
) -> float:
    """Acceleration of the first mode, m/s^2."""
    return -w * w * coefficient_per_m2 * q * q * q


def limit(t: float, first_hz: float, q: float, coefficient_per_m2: float) -> str | None:
    """The message for a softening spring that is bent beyond 1 + c q^2 = 0, from where it does not return."""
    if 1.0 + coefficient_per_m2 * q * q > 0.0:
        return None
    return (
        f"coefficient_per_m2 = {coefficient_per_m2:g}: bent by {q:.4g} m, the softening arm no longer returns at "
        f"{t:.3f} s; take a smaller one, or excite the arm less"
    )


CAUSE = Cause(
    "cubic_stiffness",
    "arm",
    name="a stiffness that changes with the deflection",
    sees=(
        "the frequency changes with the amplitude: it rises with it for a stiffening arm (positive "
        "coefficient), falls for a softening one"
    ),
    note=("A softening arm that is bent so far that it no longer returns ends a simulation with a message."),
    equation="w_1^2 (q_1 + coefficient q_1^3)",
    parameters=(size("coefficient_per_m2", "1/m^2", 1e7, 100.0, 600.0, signed=True),),
    provoke=(
        "ring-downs from a large and from a small strike, damping off; w / w_1 = 1 + 3/8 coefficient A^2."
    ),
    acts="force",
    law=law,
    confused_with={
        "gear_backlash": (
            "make small moves to and fro, of the size of the gap: play depends on the reversal, "
            "stiffness on the deflection"
        ),
    },
    limit=limit,
)
