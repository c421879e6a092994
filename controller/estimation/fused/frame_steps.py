"""The work on one frame as a sequence of steps. Each step has a cycle of the controller, so that no cycle is long.

The order is that of docs/fused.md: the date (Eqs. 18 to 28), the image (Eqs. 30 to 36), the laws (Eqs. 37 to 39), the
mixture (Eqs. 40, 41), the present (Eq. 42), and what is learnt (Eqs. 44 to 64).

The sequence is a generator. It yields the name of its next step and does that step when it is resumed, so that its
caller can see what is due.

If the next frame comes before the last step, this frame's measurement is processed first. The steps from the mixture
on only tell of this frame; they are left to the next one. Where that happens, cycles do more steps each (Pace): an arm
of 8 Hz has blocks of five cycles, and with them a frame has more steps than there are cycles to the next one.
"""

from collections.abc import Generator
from typing import TypeAlias

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.estimation.fused.accelerometer.impact_detector import ImpactReport
from stillarm.controller.estimation.fused.arm.joint_input import JointInput
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.block_history import BlockHistory
from stillarm.controller.estimation.fused.fusion.fusion import FrameFusion

Steps: TypeAlias = Generator[str, bool, None]
NOTHING = ""
# The steps in their order; those before MERGE change the filters by the frame.
DATE, ARRIVAL, STARTED = "date", "arrival", "n_i"
PREPARE, PREDICT, COMPARE, UPDATE, WEIGH = "prepare", "predict", "compare", "update", "weigh"
MERGE, PRESENT, LEARN, BLOCKS = "merge", "present", "learn", "blocks ahead"
_OF_FRAME = frozenset((DATE, ARRIVAL, STARTED, PREPARE, PREDICT, COMPARE, UPDATE, WEIGH))
_PREPARED, _TO_UPDATE = frozenset((PREDICT, COMPARE)), frozenset((UPDATE, WEIGH))


class SpreadWork:
    """Holds at most one sequence. due: name of its next step; NOTHING where none is left."""

    def __init__(self) -> None:
        """No sequence."""
        self._steps: Steps | None = None
        self.due = NOTHING

    def begin(self, steps: Steps) -> None:
        """Put a sequence in place of what is left of the one before. None of its steps has been done yet."""
        self._steps = steps
        self.due = next(steps, NOTHING)

    def advance(self) -> None:
        """Do the step that is due."""
        if self._steps is not None:
            self.due = next(self._steps, NOTHING)

    def advance_through(self, steps: frozenset[str]) -> None:
        """Do at once all that is due, as long as it is one of `steps`."""
        while self.due in steps:
            self.advance()

    def withdraw(self) -> None:
        """Tell the sequence that its preparation no longer holds, instead of resuming its next step."""
        if self._steps is not None:
            self.due = self._steps.send(True)


class Pace:
    """How many steps a cycle does: so many that a frame is told before the next one comes.

    steps: at present. One too many is taken back where cycles are left without a step.
    """

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """One step a cycle."""
        self._assumed = assumed.update
        self.steps = 1
        self._cycles = self._idle = self._untold = 0

    def see_cycle(self, *, idle: bool) -> None:
        """A cycle had time for steps; idle: none was due."""
        self._cycles += 1
        self._idle += idle

    def see_frame(self, *, told: bool, urgent: bool = False) -> None:
        """Another frame comes; told: whether the one before has been told; urgent: whether each has to be."""
        self._untold = 0 if told else self._untold + 1
        if self._untold >= (1 if urgent else self._assumed.untold_frames):
            self.steps = min(self.steps + 1, self._assumed.most_steps)
        elif told and self.steps > 1 and self._idle > self._assumed.spare_cycles * self._cycles:
            self.steps -= 1
        self._cycles = self._idle = 0


class FrameSteps:
    """now_s: time of the cycle, set by the caller. last_frame_s: when the image compared last was read.

    dated: frames whose delay was told in this cycle: number, delay, s, and its standard deviation, s; the reader clears
    it.
    """

    def __init__(self, fusion: FrameFusion, history: BlockHistory, joint_input: JointInput) -> None:
        """No frame yet."""
        self._fusion, self._history, self._joint_input = fusion, history, joint_input
        self._work = SpreadWork()
        self._pace = Pace(fusion.state.assumed)
        self._told = True  # whether the present tells of the frame begun last
        self.now_s = 0.0
        self._ahead_s = fusion.state.assumed.update.ahead_frames * fusion.state.frame_s
        self._last_instant_s = float("-inf")
        self.dated: list[tuple[int, float, float]] = []
        self.last_frame_s = float("-inf")

    def see(self, samples: list[VisualSample]) -> None:
        """Leave the last one to the cycles that follow; those before it have to be done with at once."""
        samples = samples[-self._fusion.state.assumed.update.dated_in_cycle :]
        state = self._fusion.state
        urgent = state.held_force.active or state.fresh.astray(self.now_s)
        self._pace.see_frame(told=self._told, urgent=urgent)
        self._told = False
        first_looked_at = len(samples) - self._fusion.state.assumed.update.images_in_cycle
        for place, sample in enumerate(samples):
            self.finish_frame()
            self._work.begin(self._steps(sample, self.now_s, sample.measured and place >= first_looked_at))

    def work_off(self) -> None:
        """A cycle's steps."""
        self._pace.see_cycle(idle=self._told and self._work.due == NOTHING)
        for _ in range(self._pace.steps):
            self._do_step()

    def _do_step(self) -> None:
        if not self._fusion.blocks.advance():
            self._work.advance()

    def finish_frame(self) -> None:
        """All steps that are left of the last frame but for those that only tell of it."""
        while self._work.due in _OF_FRAME:
            self._do_step()

    def finish_update(self) -> None:
        """To be called before anything else changes the bank. An image that was only prepared is prepared again."""
        if self._work.due in _PREPARED:
            self._work.withdraw()
        self._work.advance_through(_TO_UPDATE)

    def update_by_oldest_block(self) -> None:
        """Give the bank the oldest block that waits."""
        self.finish_update()
        self._history.hand_over_oldest()

    def _steps(self, sample: VisualSample, received_s: float, looked_at: bool) -> Steps:
        """Each `yield` names the step that follows it."""
        fusion, history = self._fusion, self._history
        yield DATE
        if fusion.accept(sample, received_s):
            yield ARRIVAL
            fusion.update_by_arrival()
            yield STARTED
            fusion.dates.update_by_started()
            if looked_at:
                yield from self._image_steps(sample, received_s)
        yield WEIGH
        if fusion.weigh():
            self._tell_date(sample.frame)
        yield MERGE
        history.merge(self.now_s)
        yield PRESENT
        history.restart_present(self.now_s)
        self._told = True
        yield LEARN
        if fusion.learn():
            history.forget_snapshot()
            history.restart_present(self.now_s)
        while self._block_ahead():
            yield BLOCKS
            if self._block_ahead():
                self.update_by_oldest_block()

    def _image_steps(self, sample: VisualSample, received_s: float) -> Steps:
        """From the frame's date to its measurement update. If the bank changes after PREPARE, that step is repeated."""
        fusion = self._fusion
        prepared = self._prepare(sample, received_s)  # little work: still of the step before
        while True:
            while not prepared:
                yield PREPARE
                prepared = self._prepare(sample, received_s)
                if not prepared:
                    self.update_by_oldest_block()
            if (yield PREDICT):
                prepared = False
                continue
            fusion.predict_image()
            if not (yield COMPARE):
                break
            prepared = False
        if self._compare(sample.frame, received_s):
            yield UPDATE
            fusion.update()

    def _prepare(self, sample: VisualSample, received_s: float) -> bool:
        """Aim at an image, unless a block before its exposure has yet to be processed."""
        instant_s = self._fusion.dates.expected_instant_s()
        if self._history.has_block_before(instant_s):
            return False
        self._fusion.prepare(sample, received_s, self._joint_input)
        self._last_instant_s = instant_s
        return True

    def _compare(self, frame: int, received_s: float) -> bool:
        """Compare the image with what was predicted; whether it is of use."""
        fusion, history = self._fusion, self._history
        in_use = history.in_use
        sees = (
            in_use
            and fusion.state.health.sees_impacts
            and self.now_s - history.alarm_s > fusion.state.assumed.impact_detector.again_s
        )
        of_use = fusion.compare(ImpactReport(history.impacts.suspicion, sees, in_use))
        self.last_frame_s = received_s
        if fusion.impact:
            history.impacts.forget()
        if not of_use:
            self._tell_date(frame)
        return of_use

    def _tell_date(self, frame: int) -> None:
        state = self._fusion.state
        self.dated.append((frame, state.delay_s, state.delay_std_s))

    def _block_ahead(self) -> bool:
        """Whether there is a block that the next image will want processed."""
        return self._history.has_block_before(self._last_instant_s + self._ahead_s)
