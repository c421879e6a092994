"""The effect of the joint's known motion on the sensors, so that it can be subtracted from them.

The image shows length * theta at the capture instant. The accelerometer measures
(1 - sum of participations) * length * theta'' in addition to the vibration. The joint's acceleration bends the arm by
an amount that the model predicts.
"""

from math import isfinite

from stillarm.common.files.effects import effect_of
from stillarm.common.files.model import Model
from stillarm.controller.joint.drive_model import STEPWISE_CYCLES, DriveModel
from stillarm.controller.joint.gear_play import GearPlay
from stillarm.controller.joint.history import CycleHistory
from stillarm.controller.joint.modal_response import ModalResponse

HISTORY_S = 2.5


class JointMotion:
    """Joint position and the first mode's response to it over the last seconds, on the controller's clock."""

    def __init__(self, model: Model, length_m: float, position_rad: float = 0.0) -> None:
        """Start at rest at the first reported position, or at `position_rad`."""
        self._cycle_s = model.timing.cycle_s
        drive, play = DriveModel(model.drive, self._cycle_s, position_rad), effect_of(model, "gear_backlash")
        self.play = GearPlay(drive, play["gap_rad"], play["behind_encoder"], self._cycle_s) if play else None
        """The play between motor and joint, if the model has one."""
        self._drive = self.play or drive
        self._response = ModalResponse(model.arm.modes[0], length_m, self._cycle_s)
        held = int(HISTORY_S / self._cycle_s) + 2
        self._position = CycleHistory(held)
        self._forced = CycleHistory(held)
        self._started = False
        self._cycle = 0
        self._command = 0.0

    @property
    def acceleration_rad_s2(self) -> float:
        """theta'' now, from the drive model driven by the commands sent."""
        return self._drive.acceleration_rad_s2

    @property
    def mean_acceleration_rad_s2(self) -> float:
        """Mean of theta'' over the last cycle, which has bent the arm."""
        return self._drive.mean_acceleration_rad_s2

    @property
    def velocity_rad_s(self) -> float:
        """theta' now, from the drive model."""
        return self._drive.velocity_rad_s

    @property
    def position_rad(self) -> float:
        """theta now: from the drive's report, or else from the drive model."""
        return self._drive.position_rad

    @property
    def forced_deflection_m(self) -> float:
        """The first mode's response to the joint's motion, now."""
        return self._response.deflection_m

    @property
    def forced_rate_m_s(self) -> float:
        """Rate of the first mode's response to the joint's motion, now."""
        return self._response.rate_m_s

    def begin_cycle(self, cycle: int, reported_position_rad: float) -> None:
        """Advance to `cycle` with the last command; use the drive's report if it is finite."""
        if not self._started:
            self._started = True
            self._cycle = cycle - 1
        elapsed, drive, response = cycle - self._cycle, self._drive, self._response
        for _ in range(min(elapsed, STEPWISE_CYCLES)):
            drive.advance(self._command)
            response.advance(drive.mean_acceleration_rad_s2)
        if elapsed > STEPWISE_CYCLES:
            drive.advance_many(elapsed - STEPWISE_CYCLES, self._command)
            response.advance_many(elapsed - STEPWISE_CYCLES, drive.mean_acceleration_rad_s2)
        self._cycle = cycle
        if isfinite(reported_position_rad):
            drive.report(reported_position_rad)
        self._position.write(cycle, drive.position_rad)
        self._forced.write(cycle, response.deflection_m)

    def send(self, command_rad_s: float) -> None:
        """Store the command of this cycle; a missing one (an import without commands) counts as zero."""
        self._command = command_rad_s if isfinite(command_rad_s) else 0.0

    def position_at(self, time_s: float) -> float:
        """theta at an instant of the last seconds, rad."""
        return self._position.at(time_s / self._cycle_s)

    def forced_deflection_at(self, time_s: float) -> float:
        """The first mode's response to the joint's motion at an instant of the last seconds, m."""
        return self._forced.at(time_s / self._cycle_s)
