"""The accelerometer's blocks processed by the filters, in parts that cost about the same.

Implements Eqs. 12, 14, 53 of docs/fused.md.
"""

from typing import NamedTuple

from stillarm.controller.estimation.fused.accelerometer.blocks import Block
from stillarm.controller.estimation.fused.filters.block_update import (
    BlockInnovation,
    block_innovation,
    expected_block,
    move_on,
    update_by_block,
)
from stillarm.controller.estimation.fused.filters.jumps import inflate, let_scale_walk, loosen_bias
from stillarm.controller.estimation.fused.filters.laws import QUIET
from stillarm.controller.estimation.fused.fusion.state import FusionState


class _Compared(NamedTuple):
    """A block compared, to be processed next: the arguments of block_update.update_by_block."""

    innovation: BlockInnovation
    variance: float
    shown: tuple[float, float] | None


class BlockFusion:
    """`compare` begins with a block. `advance` does the rest in parts, one a call, before anything else changes the
    bank."""

    def __init__(self, state: FusionState) -> None:
        """No block is waiting."""
        self._state = state
        self._left: Block | None = None  # compared, its end not yet reached
        self._compared: _Compared | None = None

    def compare(self, block: Block) -> None:
        """Begin with the accelerometer's oldest block not yet processed: its jumps, and its comparison with images."""
        self.finish()
        state = self._state
        bank = state.bank
        for jump in block.jumps:
            inflate(bank, jump, QUIET)
            if jump.force_step_m:
                state.held_force.step(jump.force_step_m)
        held = state.held_force.during(block.start_s, block.end_s)
        if held is not None:
            inflate(bank, held, QUIET)
        push = state.force.during(block.start_s, block.end_s)
        if push is not None:
            inflate(bank, push)
        state.unused_blocks += 1
        if block.count:
            self._weigh(block)
        self._left = block

    def _weigh(self, block: Block) -> None:
        """Compare the block with the value that images predict. A block that contradicts them counts less or not."""
        state = self._state
        bank, health = state.bank, state.health
        state.force.see_scatter(block)
        value, expected, quadrature, variance = expected_block(bank, block, state.evidence.best)
        total = variance + block.variance
        drifted = health.compare(value, expected, total)
        state.date_watch.see(value, expected, quadrature, total)
        if drifted and state.date_watch.shows_offset:
            loosen_bias(bank, drifted)
        if health.mute:
            return
        state.unused_blocks = 0
        self._watch_scale(block, value - expected, expected, total * health.doubt)
        huber = max(
            1.0, (value - expected) ** 2 / (total + drifted) / self._state.assumed.update.block_huber_nis
        )
        variance = block.variance * max(huber, health.doubt)
        self._compared = _Compared(block_innovation(bank, block), variance, state.force.shown(block))

    def _watch_scale(self, block: Block, difference: float, expected: float, variance: float) -> None:
        # A random force moves images and accelerometer alike: their departures add up, as those of a misled filter do.
        state = self._state
        if state.force.intensity or state.fresh.astray(block.end_s):
            state.scale_watch.restart()
        elif state.scale_watch.see(difference, expected, variance, block.end_s - block.start_s):
            state.as_calibrated = state.unless_forced = False
            state.fresh.remembered.forget()

    def advance(self) -> bool:
        """Process the block compared last, then, in a second call, move on to its end; False where all is done."""
        if self._left is None:
            return False
        state = self._state
        block, bank = self._left, state.bank
        if self._compared is not None:
            update_by_block(bank, *self._compared)
            self._compared = None
            return True
        self._left = None
        dt = block.end_s - bank.edge_s
        noise = state.state_noise * dt
        noise[:, state.at.phasor] = (state.phasor_noise() * dt)[:, None] + block.motion_variance(
            state.assumed.blocks.motion_doubt
        )
        move_on(bank, block, noise)
        # About the place where the joint holds the tip: there a pull would pass for a scale that walks.
        room = state.scale_watch.grown(dt)
        if room > 0.0:
            let_scale_walk(bank, room, state.held_m)
        return True

    def finish(self) -> None:
        """Do all that is left with the block compared last."""
        while self.advance():
            pass
