"""The accelerometer's blocks since the bank's instant, and the present phasors, computed through them.

Implements Eqs. 5, 12, 43 of docs/fused.md.
"""

from cmath import exp
from collections import deque
from math import sqrt

from stillarm.controller.estimation.fused.accelerometer.blocks import Block, BlockSums, Jump
from stillarm.controller.estimation.fused.accelerometer.impact_detector import Impact, ImpactDetector
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.arm.layout import Layout
from stillarm.controller.estimation.fused.fusion.fusion import FrameFusion
from stillarm.controller.estimation.fused.present import Merged, Mixture, Present


class BlockHistory:
    """Blocks wait here until the bank processes them, before the next image.

    sums: of the block under way, which began in start_cycle, at start_s, when the joint's phasor increments were
    start_sum. begun: whether there was a first cycle.
    present: the phasors now. alarm_s: when the accelerometer last reported an impact.
    """

    def __init__(
        self, at: Layout, cycle_s: float, block_s: float, fusion: FrameFusion, joint_input: JointInput
    ) -> None:
        """No block yet. block_s: how long one lasts."""
        w: list[float] = at.w.tolist()
        self._cycle_s = cycle_s
        self._fusion, self._joint_input = fusion, joint_input
        self._health = fusion.state.health
        assumed = fusion.state.assumed
        self._assumed, self._blocks_assumed = assumed.impact_detector, assumed.blocks
        self._mixture = Mixture(fusion.state)
        self.present = Present(w, at.sigma.tolist(), at.w_first)
        self.impacts = ImpactDetector(w, block_s, assumed)
        self.sums = BlockSums(at.modes, assumed)
        self.begun = False
        self.start_cycle = 0
        self.start_s = 0.0
        self.start_sum = [0j] * at.modes
        self.alarm_s = float("-inf")
        self._blocks: deque[Block] = deque()
        self._open_jumps: tuple[Jump, ...] = ()  # in the block under way
        self._taken: list[Block] = []  # by the bank, since the snapshot
        self._snapshot: Merged | None = None

    def begin(self, cycle: int, time_s: float) -> None:
        """The first cycle: the block under way begins here."""
        self.begun = True
        self.start_cycle, self.start_s = cycle, cycle * self._cycle_s
        self._fusion.bank.edge_s = time_s
        self.restart_present(time_s)

    def __len__(self) -> int:
        return len(self._blocks)

    def has_block_before(self, time_s: float) -> bool:
        """Whether the oldest block waiting ends before that."""
        return bool(self._blocks) and self._blocks[0].end_s <= time_s

    @property
    def in_use(self) -> bool:
        """Whether the accelerometer's samples count at present."""
        return bool(self._blocks) and self._blocks[-1].count > 0 and not self._health.mute

    def later_than(self, time_s: float) -> list[Block]:
        """Blocks waiting that end after that."""
        return [block for block in self._blocks if block.end_s > time_s]

    def close(self, cycle: int) -> Block:
        """End the block under way; the next one begins."""
        start_s, end_s = self.start_s, cycle * self._cycle_s
        sums = self._joint_input.sum
        step = tuple(now - then for now, then in zip(sums, self.start_sum, strict=True))
        block = self.sums.close(start_s, end_s, self._health.variance, step)
        self.start_cycle, self.start_s, self.start_sum = cycle, end_s, sums.copy()
        self.sums.clear()
        block.jumps, self._open_jumps = self._open_jumps, ()
        self._blocks.append(block)
        return block

    def compare(self, block: Block) -> None:
        """Compare a block that ends now with the present: it shows an impact, or it corrects the present."""
        present, health = self.present, self._health
        residual = present.residual(block)
        if health.mute:
            return
        noise = block.variance * health.doubt
        variance = noise + present.bias_variance
        usual = max(abs(present.z[0]), self._assumed.usual_stds * sqrt(variance))
        impact = self.impacts.see(block, residual, variance, usual)
        if impact is None or not health.alarm(block.end_s, impact.excess):
            present.update_by_block(block, noise, self._fusion.force.shown(block), at_end=True)
        else:
            self._mark(impact)

    def compare_if_waiting(self, block: Block) -> None:
        """`compare`, unless the bank has processed the block."""
        if block in self._blocks:
            self.compare(block)

    def _mark(self, impact: Impact) -> None:
        """Put the impact into the history where it began, and compute the present anew."""
        self.impacts.forget()
        self.alarm_s = self._blocks[-1].end_s
        place = max(0, len(self._blocks) - impact.blocks_ago)
        block = self._blocks[place]
        block.jumps += (Jump.guessed(block.start_s, impact.sizes_m, assumed=self._blocks_assumed),)
        self.restart_present(self._blocks[-1].end_s)

    def add_jump(self, time_s: float, jump: Jump) -> bool:
        """A change within the blocks that wait or the one under way; False for one before them."""
        if time_s >= self.start_s:
            self._open_jumps += (jump,)
            return True
        block = next((one for one in reversed(self._blocks) if one.start_s <= time_s), None)
        if block is None:
            return False
        block.jumps += (jump,)
        return True

    def block_at(self, time_s: float) -> Block | None:
        """The block in which an instant lies, of those waiting or processed since the snapshot; None for neither."""
        known = (*self._taken, *self._blocks)
        return next((one for one in reversed(known) if one.start_s <= time_s), None)

    def waits(self, block: Block | None) -> bool:
        """Whether the bank has yet to process the block."""
        return block is not None and block in self._blocks

    def hand_over_oldest(self) -> None:
        """Give the bank the oldest block; the image under way must have been processed before."""
        block = self._blocks.popleft()
        self._fusion.blocks.compare(block)
        self._taken.append(block)

    def forget_taken(self) -> None:
        """Forget the blocks taken: more than a capture delay's were waiting, and the bank has gone on without an
        image."""
        self._snapshot = None
        self._taken.clear()

    def forget_snapshot(self) -> None:
        """Forget the snapshot: the bank has changed, and not only by the blocks handed over."""
        self._snapshot = None

    def merge(self, now_s: float) -> None:
        """Take a snapshot of the filters' mixture."""
        self._fusion.blocks.finish()
        self._snapshot = self._mixture.merged(now_s)
        self._taken.clear()

    def restart_present(self, now_s: float) -> None:
        """From the bank's instant to now."""
        if self._snapshot is None:
            self.merge(now_s)
        assert self._snapshot is not None
        merged, present, health = self._snapshot, self.present, self._health
        present.restart(
            list(merged.phasors), [row.copy() for row in merged.covariance], merged.slow,
            merged.bias, merged.bias_variance, merged.force, self._cycle_s,
        )  # fmt: skip
        for block in (*self._taken, *self._blocks):
            for jump in block.jumps:
                present.inflate(jump)
            if block.count and not health.mute:
                noise = block.variance * health.doubt
                present.update_by_block(block, noise, self._fusion.force.shown(block), at_end=False)
            self._push(block.start_s, block.end_s)
            present.move_on(block)
            present.widen(block.motion_variance(self._blocks_assumed.motion_doubt))
        for jump in self._open_jumps:
            present.inflate(jump)
        rest = now_s - self.start_s
        for i, start in enumerate(self.start_sum):
            turned = present.z[i] * exp(present.slow[i] * rest)
            present.z[i] = turned + self._joint_input.sum[i] - start

    def widen_present(self, block: Block) -> None:
        """Widen the present by what may have happened in the block that has just been closed."""
        self.present.widen(
            self._mixture.phasor_noise() * (block.end_s - block.start_s)
            + block.motion_variance(self._blocks_assumed.motion_doubt)
        )
        self._push(block.start_s, block.end_s)

    def _push(self, start_s: float, end_s: float) -> None:
        """Widen the present by what a random force and a lasting force may have done."""
        push = self._fusion.force.during(start_s, end_s)
        if push is not None:
            self.present.inflate(push)
        held = self._fusion.state.held_during(start_s, end_s)
        if held is not None:
            self.present.inflate(held)
