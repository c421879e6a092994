"""The mounting of an accelerometer: from the sensor's three axes to the measured axis."""

from math import cos, radians, sin

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2

Vector = tuple[float, float, float]


def measured_direction(device: AccelerometerDevice) -> Vector:
    """The weights of the sensor's x, y, z in the measured acceleration: sign times a row of the mounting's rotation.

    The rotation maps the sensor's axes to the arm's: R = Rz Ry Rx, with the angles in rotation_deg.
    """
    row = _rotation(device.rotation_deg)["xyz".index(device.axis)]
    return device.sign * row[0], device.sign * row[1], device.sign * row[2]


def sensed_axes(acceleration_m_s2: float, device: AccelerometerDevice) -> Vector:
    """The acceleration along the sensor's own (x, y, z), m/s^2, for a reading of `acceleration_m_s2` when mounted as
    configured.

    The arm has two other axes. One is horizontal and has no acceleration. The other (z, or y if z is measured) has
    gravity.
    """
    arm = [0.0, 0.0, 0.0]
    arm["yz".index("y" if device.axis == "z" else "z") + 1] = STANDARD_GRAVITY_M_S2
    arm["xyz".index(device.axis)] = device.sign * acceleration_m_s2
    if device.rotation_deg == (0.0, 0.0, 0.0):
        return arm[0], arm[1], arm[2]
    rotation = _rotation(device.rotation_deg)
    x, y, z = (sum(rotation[row][column] * arm[row] for row in range(3)) for column in range(3))
    return x, y, z


def _rotation(angles_deg: Vector) -> tuple[Vector, Vector, Vector]:
    a, b, c = (radians(angle) for angle in angles_deg)
    return (
        (
            cos(c) * cos(b),
            cos(c) * sin(b) * sin(a) - sin(c) * cos(a),
            cos(c) * sin(b) * cos(a) + sin(c) * sin(a),
        ),
        (
            sin(c) * cos(b),
            sin(c) * sin(b) * sin(a) + cos(c) * cos(a),
            sin(c) * sin(b) * cos(a) - cos(c) * sin(a),
        ),
        (-sin(b), cos(b) * sin(a), cos(b) * cos(a)),
    )
