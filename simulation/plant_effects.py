"""Where an extended plant adds to the linear equations: force terms on the first mode, rules on the drive's command.

Each cause that the model file names as an effect is one of these (plant_forces, drive_rules), or has a place of its
own in the plant: dry_friction, gear_play, frequency_change.
"""

from collections.abc import Callable
from typing import Protocol


class ForceTerm(Protocol):
    """An acceleration of the first mode that depends on its state or on time."""

    def acceleration_m_s2(
        self, angular_frequency: float, deflection_m: float, rate_m_s: float, time_s: float, duration_s: float
    ) -> float:
        """Mean of the acceleration over the next `duration_s`, which lets damping slow a motion but not reverse it.

        angular_frequency: of the mode, at present, rad/s. time_s: from the recording's start. A duration of 0 asks
        for the present value.
        """


CommandRule = Callable[[float], float]
"""A rule of the drive, such as a dead band: velocity command after dead time and limit -> the one obeyed,
rad/s."""
