"""One frame's steps: their order, one a cycle, and what a frame that comes too soon leaves undone."""

from itertools import pairwise

import pytest

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Mode
from stillarm.controller.estimation.estimate import Estimate, Observation
from stillarm.controller.estimation.fused import frame_steps as steps
from stillarm.controller.estimation.fused.frame_steps import NOTHING, Pace
from stillarm.controller.estimation.fused.method import FusedMethod
from stillarm.controller.joint.joint_motion import JointMotion
from tests.reference.ringing_world import CYCLE_S, model_for, ring

ORDER = (
    steps.DATE, steps.ARRIVAL, steps.STARTED, steps.PREPARE, steps.PREDICT, steps.COMPARE, steps.UPDATE, steps.WEIGH,
    steps.MERGE, steps.PRESENT, steps.LEARN, steps.BLOCKS,
)  # fmt: skip


def run(seconds: float, doubled: bool = False) -> tuple[list[list[str]], list[Estimate]]:
    """What is due after each cycle, by frame, and the estimates. doubled: two frames are read in each such cycle."""
    model = model_for(0.006, 0.3)
    trial = ring(model, 5, seconds, delay="constant", excitation="steady")
    method, joint = FusedMethod(model, Settings().fused, "model"), JointMotion(model, 2.0)
    courses: list[list[str]] = []
    said = []
    waiting: list[VisualSample] = []
    for cycle in range(len(trial.deflection)):
        joint.begin_cycle(cycle, float("nan"))
        waiting += trial.samples.get(cycle, [])
        samples, waiting = (waiting, []) if len(waiting) > doubled else ([], waiting)
        acceleration = float(trial.acceleration[cycle])
        said.append(method.update(Observation(cycle, cycle * CYCLE_S, acceleration, samples, joint)))
        joint.send(0.0)
        if samples:
            courses.append([])
        if courses:
            courses[-1].append(method._steps._work.due)
    return courses, said


def test_each_cycle_does_one_step_at_most_and_the_steps_keep_their_order() -> None:
    courses, _ = run(2.0)
    assert len(courses) > 50
    for course in courses[:-1]:
        assert course[0] == steps.DATE
        places = [ORDER.index(due) for due in course if due != NOTHING]
        for before, after in pairwise(places):
            again = ORDER[after] in (steps.PREPARE, steps.BLOCKS) and after <= before
            skipped = after - before <= 1 or (ORDER[before], ORDER[after]) in (
                (steps.STARTED, steps.PREDICT),  # prepared with the n_i, for no block was left before it
                (steps.STARTED, steps.WEIGH),
                (steps.COMPARE, steps.WEIGH),
            )
            assert again or skipped, course


def test_an_image_delay_is_told_once_within_some_cycles() -> None:
    courses, said = run(2.0)
    told = [frame.frame for one in said for frame in one.dated]
    assert told == sorted(set(told)) and len(told) >= len(courses) - 1


def test_of_two_images_read_at_once_both_are_dated() -> None:
    """The first one's measurement is processed in the cycle in which both were read."""
    _, said = run(2.0, doubled=True)
    told = [frame.frame for one in said for frame in one.dated]
    assert told == list(range(told[0], told[0] + len(told))) and len(told) > 50


@pytest.mark.slow
def test_frames_of_a_fast_arm_are_all_told() -> None:
    """Blocks of an 8 Hz arm take five cycles and three steps each. With a step a cycle the present told of one frame in
    ten, and lay up to a second behind the filters."""
    model = model_for(0.006, 0.3, modes=[Mode(frequency_hz=8.0)])
    trial = ring(model, 5, 3.0, delay="constant", excitation="steady")
    method, joint = FusedMethod(model, Settings().fused, "model"), JointMotion(model, 2.0)
    behind, frames = [], 0
    for cycle in range(len(trial.deflection)):
        joint.begin_cycle(cycle, float("nan"))
        samples = trial.samples.get(cycle, [])
        if samples:  # before this frame: whether the present tells of the last one
            behind.append(0 if method._steps._told else 1 + (behind[-1] if behind else 0))
            frames += 1
        method.update(Observation(cycle, cycle * CYCLE_S, float(trial.acceleration[cycle]), samples, joint))
        joint.send(0.0)
    late = behind[frames // 4 :]
    assert frames > 150
    assert max(late) <= 3
    assert sum(one > 0 for one in late) < 0.4 * len(late)


def test_a_cycle_does_one_step_more_after_each_frame_but_the_first_that_was_not_told() -> None:
    pace = Pace()
    for wanted in (1, 2, 3, 4, 4):
        pace.see_frame(told=False)
        assert pace.steps == wanted
    pace = Pace()
    pace.see_frame(told=False, urgent=True)
    assert pace.steps == 2


@pytest.mark.parametrize(("idle", "wanted"), [(4, 2), (5, 1)])
def test_a_step_is_taken_back_where_cycles_are_left(idle: int, wanted: int) -> None:
    pace = Pace()
    pace.see_frame(told=False)
    pace.see_frame(told=False)
    for cycle in range(10):
        pace.see_cycle(idle=cycle < idle)
    pace.see_frame(told=True)
    assert pace.steps == wanted
    pace.see_frame(told=True)
    assert pace.steps == wanted  # without a cycle for steps nothing is known
