"""A restarted supervisor has another zero: this is detected and recorded, and causes no jump of the command."""

from math import nan

import numpy as np
import pytest

from stillarm.benchmarks.faults.virtual_faults import run_virtual_fault
from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import load_assumed_model, load_configuration
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import DelayEstimate, Estimate, Observation, Status
from stillarm.controller.input.exchange import ControllerExchange
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.loop.recorded import frame_sample, visual_sample
from stillarm.controller.loop.step import MethodAcrossRestarts
from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration
from stillarm.supervisor.exchange import SupervisorExchange


def sample(frame: int, *, restarted: bool = False) -> VisualSample:
    return VisualSample(frame, 0, 0, 1.0, restarted=restarted)


def test_the_first_sample_of_a_second_supervisor_is_marked_and_no_other() -> None:
    controller = ControllerExchange(DEMO_KEY, 11)
    marks = []
    for session in (22, 23, 24):
        supervisor = SupervisorExchange(DEMO_KEY, session, 1)
        for frame in range(3):
            supervisor.take([controller.timestamp(10 * session + frame)])
            supervisor.begin_cycles()
            taken = controller.take([supervisor.end_cycle(sample(frame))], 10 * session + 9)
            marks += [(session, s.frame, s.restarted) for s in taken]
    assert [(session, marked) for session, _, marked in marks if session > 22][:3] == [
        (23, True),
        (23, False),
        (24, True),
    ]
    assert sum(marked for _, _, marked in marks) == 2


def test_the_mark_survives_recording() -> None:
    """A replay therefore restarts the method in the same cycle."""
    assert visual_sample(frame_sample(sample(1, restarted=True), 5, 0.001)).restarted
    assert not visual_sample(frame_sample(sample(1), 5, 0.001)).restarted


class Counted:
    """Says how many samples it was given."""

    def __init__(self) -> None:
        self.samples: list[int] = []

    def update(self, observation: Observation) -> Estimate:
        self.samples += [s.frame for s in observation.samples]
        return Estimate(DelayEstimate(0.07, 0.001, Status.ESTIMATED), float(len(self.samples)))


def test_a_method_begins_anew_with_what_the_new_supervisor_sent() -> None:
    """In a cycle with samples of both supervisors, the method gets those of the new one."""
    made: list[Counted] = []

    def make() -> Counted:
        made.append(Counted())
        return made[-1]

    method = MethodAcrossRestarts(make)
    joint = JointMotion(Model(), 1.0)
    for samples in ([sample(1)], [], [sample(2), sample(0, restarted=True), sample(1)], [sample(2)]):
        estimate = method.update(Observation(0, 0.0, nan, samples, joint))
    assert [each.samples for each in made] == [[1], [0, 1, 2]]
    assert estimate.deflection_m == 3.0


@pytest.mark.slow
def test_a_restarted_supervisor_kicks_nobody() -> None:
    """Its zero is where the tip happened to be, of a vibration of some 10 mm: commands stay those of damping it.

    With images of both zeros in one fit it was 0.2 rad/s, the damping's limit, for seconds.
    """
    path = default_simulation_configuration()
    configuration = load_configuration(path)
    model = load_assumed_model(configuration, path)
    verdicts = run_virtual_fault("supervisor killed", configuration, model, 4, 3)
    assert all(verdict.violations == [] for verdict in verdicts)
    assert max(verdict.command_max for verdict in verdicts) < 0.03


class Failing:
    """Gives good numbers until its third cycle."""

    def __init__(self, harm: float | Exception) -> None:
        self.harm, self.cycles = harm, 0

    def update(self, observation: Observation) -> Estimate:
        self.cycles += 1
        if self.cycles == 3 and isinstance(self.harm, Exception):
            raise self.harm
        value = self.harm if self.cycles == 3 and isinstance(self.harm, float) else 0.001
        return Estimate(
            DelayEstimate(0.07, 0.001, Status.ESTIMATED), value, 0.0, 1e-4, status=Status.ESTIMATED
        )


@pytest.mark.parametrize("harm", [nan, OverflowError("too large"), np.linalg.LinAlgError("singular")])
def test_a_method_whose_numbers_fail_begins_anew_and_says_so(harm: float | Exception) -> None:
    method, joint = MethodAcrossRestarts(lambda: Failing(harm)), JointMotion(Model(), 1.0)
    said = [method.update(Observation(k, 0.001 * k, 0.0, [], joint)) for k in range(5)]
    assert [one.status for one in said] == [Status.ESTIMATED] * 2 + [Status.INVALID] + [Status.ESTIMATED] * 2
    assert said[2].reason == "numbers out of range: started again"
    assert method.failures == 1
