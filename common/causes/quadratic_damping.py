"""Damping that grows with the square of the speed."""

from stillarm.common.causes.declaration import Cause, size


def law(
    t: float, theta: float, omega: float, q: float, v: float, w: float, coefficient_per_m: float
) -> float:
    """Acceleration of the first mode, m/s^2."""
    drag = coefficient_per_m * v * v
    return -drag if v.real > 0.0 else drag


CAUSE = Cause(
    "quadratic_damping",
    "arm",
    name="damping that grows with the square of the speed",
    sees=(
        "large vibrations lose a larger share of their amplitude in each swing than small ones do, as "
        "in air or oil"
    ),
    equation="q_1'' = ... - coefficient q_1' |q_1'|",
    parameters=(size("coefficient_per_m", "1/m", 1e4, 1.0, 10.0),),
    provoke="ring-downs from a large and from a small strike, damping off.",
    acts="force",
    law=law,
    corner=True,
    confused_with={
        "accelerometer_sensitivity_drift": (
            "record the camera too, or strike the arm equally hard at the beginning and at the end"
        ),
    },
)
