"""Applies an impact or a force step that the accelerometer has measured to filters and present.

Implements Eqs. 16, 55 of docs/fused.md.
"""

from stillarm.controller.estimation.fused.accelerometer.blocks import Jump, along_rate
from stillarm.controller.estimation.fused.accelerometer.impact_meter import ForceStep, MeasuredImpact
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.block_history import BlockHistory
from stillarm.controller.estimation.fused.filters.jumps import add_step, inflate
from stillarm.controller.estimation.fused.frame_steps import FrameSteps
from stillarm.controller.estimation.fused.fusion.fusion import FrameFusion


class MeasuredChanges:
    """Each change is applied at its own instant. Only for arms of one mode."""

    def __init__(
        self, at: Layout, cycle_s: float, fusion: FrameFusion, history: BlockHistory, frame: FrameSteps,
        joint_input: JointInput,
    ) -> None:  # fmt: skip
        """frame: has what it was looking at processed before the bank changes."""
        self._w, self._cycle_s = float(at.w[0]), cycle_s
        self._w_first = at.w_first
        self._fusion, self._history, self._frame = fusion, history, frame
        self._joint_input = joint_input

    @property
    def force_held(self) -> bool:
        """Whether images have shown a force that lasts."""
        return self._fusion.held_force.active

    def take(self, change: MeasuredImpact | ForceStep, now_s: float) -> None:
        """Apply a change whose measurement has just ended."""
        self._history.impacts.forget()
        if isinstance(change, ForceStep):
            self._take_force_step(change, now_s)
        else:
            self._take_impact(change, now_s)

    def _take_force_step(self, step: ForceStep, now_s: float) -> None:
        """A force that has begun, changed or ended."""
        time_s, history = step.cycle * self._cycle_s, self._history
        self._fusion.held_force.step(step.size_m)
        if not history.add_jump(time_s, Jump.stepped(time_s, step.size_m, self._fusion.state.assumed.blocks)):
            return  # images exposed since then have seen it
        history.forget_snapshot()
        history.restart_present(now_s)

    def _take_impact(self, impact: MeasuredImpact, now_s: float) -> None:
        """The impact's step of the phasors."""
        history, time_s = self._history, impact.cycle * self._cycle_s
        per_sum = self._w_first**2 * self._cycle_s / self._w  # of samples as deflection: velocity over w
        size, std = -impact.sum_m * per_sum, impact.sum_std_m * per_sum
        step = [size * along_rate(self._w, time_s)]
        across = abs(size) * self._w * impact.cycle_std * self._cycle_s
        jump = Jump(time_s, (std,), (min(across, std),))
        self._joint_input.add(time_s, step)
        if time_s >= history.start_s:
            history.add_jump(time_s, jump)
            history.restart_present(now_s)
            return
        history.start_sum = [one + more for one, more in zip(history.start_sum, step, strict=True)]
        block = history.block_at(time_s)
        if block is not None:
            block.step = tuple(one + more for one, more in zip(block.step, step, strict=True))
            block.jumps += (jump,)
        if not history.waits(block):
            self._frame.finish_update()
            self._fusion.blocks.finish()
            add_step(self._fusion.bank, step)
            inflate(self._fusion.bank, jump)
            if block is None:
                history.forget_snapshot()
        history.restart_present(now_s)
