"""The controller's input of a cycle."""

from dataclasses import dataclass, field
from math import nan

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.datagrams.visual_sample import VisualSample


@dataclass(slots=True)
class CycleInput:
    """The input of a cycle. Missing numbers are NaN.

    joint_age_s: age of the drive's report; NaN for a drive that reports nothing
    reference_rad_s: the external joint velocity reference, as given
    damping_allowed: the operator's or schedule's permission
    samples: the visual samples read in this cycle, in order of arrival
    deflection_m: measured directly, for instance by a strain gauge
    operator: the operator's requests, bits of stillarm.controller.safety.table.Operator
    adjustment: another method or gain that the operator asks for
    """

    cycle: int
    acceleration_m_s2: float = nan
    joint_position_rad: float = nan
    joint_velocity_rad_s: float = nan
    joint_age_s: float = nan
    reference_rad_s: float = 0.0
    damping_allowed: bool = False
    samples: list[VisualSample] = field(default_factory=list)
    deflection_m: float = nan
    operator: int = 0
    adjustment: Adjustment | None = None
