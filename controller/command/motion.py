"""Shapes the external reference, and passes it to the joint as far as motion is permitted.

Entry and exit are smooth. If the joint may move again while a reference is present, the reference fades in. If the
joint may no longer move, the rest of the reference, including the shaper's tail, fades out, or is cut if required.
"""

from typing import Literal

from stillarm.common.files.model import Model
from stillarm.controller.command.damping import JointDamping
from stillarm.controller.command.limits import CommandLimits
from stillarm.controller.command.shaping import ReferenceShaper
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.safety.machine import StateMachine
from stillarm.drivers.drives.drive_gateway import DEAD_MAN_S

ENTRY_S = 0.2
FADE_S = 0.1


class Motion:
    """The shaper, and the weight of its output."""

    def __init__(self, model: Model, shaping: Literal["none", "zv", "zvd"]) -> None:
        """At rest."""
        self._cycle_s = model.timing.cycle_s
        self._shaper = ReferenceShaper(shaping, model.arm.modes[0], self._cycle_s)
        self._weight = 0.0
        self._resting = True

    def reference(
        self,
        cycle: int,
        elapsed: int,
        reference_rad_s: float,
        permission: StateMachine,
        limits: CommandLimits,
        damping: JointDamping,
        joint: JointMotion,
    ) -> float:
        """The reference that is passed on in a cycle, rad/s. Resets limits and damping when motion begins or ends."""
        if elapsed * self._cycle_s > DEAD_MAN_S:  # the drive has stopped by itself
            limits.restart()
        if not permission.may_move:
            return self._leave(cycle, elapsed, reference_rad_s, permission.at_once, damping, joint)
        if self._resting:
            self._resting = False
            self._shaper.restart()
            damping.anchor(joint.position_rad)
            shaped = self._shaper.shape(cycle, reference_rad_s)
        else:
            shaped = self._shaper.shape(cycle, reference_rad_s)
            damping.follow_reference(shaped * self._weight, joint.position_rad, elapsed)
        if self._weight < 1.0:
            enters = shaped != 0.0
            self._weight = min(1.0, self._weight + elapsed * self._cycle_s / ENTRY_S) if enters else 1.0
        return shaped * self._weight

    def _leave(
        self,
        cycle: int,
        elapsed: int,
        reference_rad_s: float,
        at_once: bool,
        damping: JointDamping,
        joint: JointMotion,
    ) -> float:
        if at_once:
            damping.cut()
            self._weight = 0.0
        else:
            self._weight = max(0.0, self._weight - elapsed * self._cycle_s / FADE_S)
        if self._weight == 0.0:
            self._resting = True
            return 0.0
        shaped = self._shaper.shape(cycle, reference_rad_s) * self._weight
        damping.follow_reference(shaped, joint.position_rad, elapsed)
        return shaped
