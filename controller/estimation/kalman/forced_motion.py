"""The response of all modes to the joint's motion: a known input that the filters need not estimate."""

from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import Observation
from stillarm.controller.joint.drive_model import STEPWISE_CYCLES
from stillarm.controller.joint.history import CycleHistory
from stillarm.controller.joint.joint_motion import HISTORY_S, JointMotion
from stillarm.controller.joint.modal_response import ModalResponse


class ForcedMotion:
    """The first mode's response comes from the joint motion; those of the further modes are computed here."""

    def __init__(self, model: Model, length_m: float) -> None:
        """From rest."""
        modes = model.arm.modes
        self._cycle_s = model.timing.cycle_s
        self._first = modes[0]
        self._further = [
            (mode, ModalResponse(mode, length_m, self._cycle_s), share)
            for mode, share in zip(modes[1:], image_shares(model, length_m)[1:], strict=True)
        ]
        self._rigid_share = (1.0 - sum(mode.participation for mode in modes)) * length_m
        self._seen = CycleHistory(int(HISTORY_S / self._cycle_s) + 2)
        self._cycle: int | None = None

    def see_cycle(self, observation: Observation) -> None:
        """Advance the further modes. Skipped cycles use the joint's acceleration of this cycle."""
        if not self._further:
            return
        elapsed = 1 if self._cycle is None else observation.cycle - self._cycle
        self._cycle = observation.cycle
        acceleration = observation.joint.mean_acceleration_rad_s2
        for _, response, _ in self._further:
            for _ in range(min(elapsed, STEPWISE_CYCLES)):
                response.advance(acceleration)
            if elapsed > STEPWISE_CYCLES:
                response.advance_many(elapsed - STEPWISE_CYCLES, acceleration)
        seen = sum(share * response.deflection_m for _, response, share in self._further)
        self._seen.write(observation.cycle, seen)

    def image_deflection_at(self, joint: JointMotion, time_s: float) -> float:
        """The part that the image shows at an instant of the last seconds, in metres of the first mode."""
        first = joint.forced_deflection_at(time_s)
        return first + self._seen.at(time_s / self._cycle_s) if self._further else first

    def deflection_m(self, joint: JointMotion) -> float:
        """Sum over the modes, now."""
        return joint.forced_deflection_m + sum(response.deflection_m for _, response, _ in self._further)

    def rate_m_s(self, joint: JointMotion) -> float:
        """Rate of that sum, now."""
        return joint.forced_rate_m_s + sum(response.rate_m_s for _, response, _ in self._further)

    def tip_acceleration_m_s2(self, joint: JointMotion) -> float:
        """s'' without the free vibration: (1 - sum of participations) L theta'' - sum of w^2 q + 2 zeta w q'."""
        total = self._rigid_share * joint.acceleration_rad_s2
        w, zeta = self._first.angular_frequency, self._first.damping_ratio
        total -= w * w * joint.forced_deflection_m + 2.0 * zeta * w * joint.forced_rate_m_s
        for mode, response, _ in self._further:
            w, zeta = mode.angular_frequency, mode.damping_ratio
            total -= w * w * response.deflection_m + 2.0 * zeta * w * response.rate_m_s
        return total


def image_shares(model: Model, length_m: float) -> list[float]:
    """Image motion of each mode per metre, relative to the first mode: a turning tip shows them unequally."""
    camera = model.camera
    slopes = tip_slopes_per_m(length_m, len(model.arm.modes))
    moves = [camera.scale_px_per_m + camera.rotation_px_per_rad * slope for slope in slopes]
    return [move / moves[0] for move in moves]
