"""One frame's steps: their order, one a cycle, and what a frame that comes too soon leaves undone."""

from itertools import pairwise

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.estimation.estimate import Estimate, Observation
from stillarm.controller.estimation.fused import frame_steps as steps
from stillarm.controller.estimation.fused.frame_steps import NOTHING
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
