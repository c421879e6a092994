"""A method on recorded cycles, as the controller runs it: implausible values are missing; a pause begins it anew."""

from collections.abc import Callable

from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import Estimate, Method, Observation
from stillarm.controller.input.plausible_input import PlausibleInput
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.loop.recorded import RecordedCycle
from stillarm.controller.loop.step import MethodAcrossRestarts


class FollowedMethod:
    """One method with a joint of its own. It commands nothing: the joint moves as the commands were recorded."""

    def __init__(self, make: Callable[[], Method], model: Model, length_m: float) -> None:
        """make: a new method; model, length_m: of the arm, as declared."""
        self._make, self._model, self._length_m = make, model, length_m
        self._cycle_s = model.timing.cycle_s
        self._plausible = PlausibleInput(model, length_m)
        self._estimator = MethodAcrossRestarts(make)
        self._joint = JointMotion(model, length_m)

    def step(self, cycle: RecordedCycle) -> Estimate:
        """The method's estimate in the next cycle."""
        read, _, begin_anew = self._plausible.admit(cycle.read)
        if begin_anew:
            self._estimator = MethodAcrossRestarts(self._make)
            self._joint = JointMotion(self._model, self._length_m, self._joint.position_rad)
        self._joint.begin_cycle(read.cycle, read.joint_position_rad)
        time_s = read.cycle * self._cycle_s
        estimate = self._estimator.update(
            Observation(
                read.cycle, time_s, read.acceleration_m_s2, read.samples, self._joint, read.deflection_m
            )
        )
        self._joint.send(cycle.command_rad_s)
        return estimate
