"""Units by magnitude: what is left when neither file nor name states one. Each guess comes with its reason."""

import numpy as np

from stillarm.tables.guesses.names import ANGLE, CURRENT, ROTATION, TEMPERATURE, VOLTAGE
from stillarm.tables.guesses.shape import TURNS, Shape, encoder_counts
from stillarm.tables.guesses.spectra import Floats

_TURNS_OF_AN_ARM = 2.0  # joints of arms turn less than this each way; a larger number is in degrees
_GRAVITY = {"g": 1.0, "m/s2": 9.80665, "mg": 1000.0}
_TILT = 0.15  # of gravity: what vibration and a sensor's error leave
_AMPERES = (0.02, 200.0)
_VOLTS = (0.2, 600.0)


def angle_unit(shape: Shape) -> tuple[str, str]:
    """rad or deg by an encoder's step, else by the size; empty where both fit."""
    if shape.step is not None:
        counts = {unit: encoder_counts(shape.step, turn) for unit, turn in TURNS.items()}
        fitting = [(unit, count) for unit, count in counts.items() if count is not None]
        if len(fitting) == 1:
            return fitting[0][0], f"its step is 1/{fitting[0][1]} of a turn"
    largest = max(abs(shape.low), abs(shape.high))
    if largest > _TURNS_OF_AN_ARM * TURNS["rad"]:
        return "deg", f"reaches {largest:.3g}, more than an arm turns in rad"
    return "", ""


def gravity_unit(axes: list[Floats]) -> tuple[str, str]:
    """g, m/s2 or mg by the length of the mean acceleration over all axes, which is gravity for a sensor in place."""
    length = float(np.sqrt(sum(float(np.nanmedian(axis)) ** 2 for axis in axes)))
    for unit, gravity in _GRAVITY.items():
        if abs(length / gravity - 1.0) < _TILT:
            return unit, f"the axes' mean is {length:.3g}, gravity in {unit}"
    return "", ""


def size_unit(quantity: str, shape: Shape) -> tuple[str, str]:
    """The usual unit of a quantity where the values lie in its usual range; empty otherwise."""
    largest = max(abs(shape.low), abs(shape.high))
    if quantity == CURRENT and _AMPERES[0] < largest < _AMPERES[1]:
        return "A", f"reaches {largest:.3g}, by size"
    if quantity == CURRENT and largest >= _AMPERES[1]:
        return "mA", f"reaches {largest:.3g}, by size"
    if quantity == VOLTAGE and _VOLTS[0] < largest < _VOLTS[1]:
        return "V", f"reaches {largest:.3g}, by size"
    if quantity == TEMPERATURE and 5.0 < shape.mean < 120.0:
        return "°C", f"about {shape.mean:.3g}, by size"
    if quantity in (ANGLE, ROTATION):
        return angle_unit(shape)
    return "", ""
