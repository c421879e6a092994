"""Rig, supervisor and controller in virtual time: the same step functions, deterministic from a seed.

One pass of the loop is one controller cycle. The order is that of the rig in real time: the sensors show the state at
the cycle's start, the controller answers, the arm moves on under the answer. The datagrams between supervisor and
controller are real ones; the drive's are left out: its commands are taken over directly, by way of the drive's velocity
loop where the joint has one.
"""

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from math import inf, nan
from typing import Protocol

import msgspec
import numpy as np

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.effects import declared
from stillarm.common.files.effects_check import check_effects
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario
from stillarm.common.user_error import UserError
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.exchange import ControllerExchange
from stillarm.controller.loop.recorded import estimate_sample, fast_sample, frame_sample
from stillarm.controller.loop.step import Controller
from stillarm.drivers.cameras.shared_memory_camera import ASK_AGAIN_S
from stillarm.drivers.drives.drive import JointState
from stillarm.drivers.drives.velocity_loop import VelocityLoop
from stillarm.simulation.arm.disturbance import DISTURBANCE_STREAM, Disturbance
from stillarm.simulation.arm.plant import Plant
from stillarm.simulation.camera.camera_timing import AFTER_DELIVERY_S
from stillarm.simulation.camera.pose_history import PoseHistory
from stillarm.simulation.camera.virtual_camera import Delivery, VirtualCamera
from stillarm.simulation.recording.clock_steps import ClockSteps, refuse_step_of_absent_stamps
from stillarm.simulation.recording.truth import strike_line, true_state
from stillarm.simulation.sensors.accelerometer_effects import accelerometer_effects
from stillarm.simulation.sensors.accelerometer_reading import accelerometer_reading
from stillarm.simulation.sensors.accelerometer_signal import ACCELEROMETER_STREAM, AccelerometerSignal
from stillarm.supervisor.exchange import SupervisorExchange
from stillarm.supervisor.step import Supervisor

_CONTROLLER_SESSION, _SUPERVISOR_SESSION = 1, 2
_REPORT_EVERY = 1000  # cycles
_COUNTED_EVERY = 10  # cycles
# tracking and network; the wait for the next cycle adds half a cycle
_PROCESSING_S = AFTER_DELIVERY_S - 0.0005


class MessageSink(Protocol):
    """Takes the messages of a recording."""

    def write(self, topic_name: str, message: msgspec.Struct) -> None:
        """Append a message of a topic of the table."""


@dataclass
class PartCosts:
    """Seconds of real time that each part of a simulation took, from every tenth cycle."""

    seconds: dict[str, float] = field(default_factory=dict)
    _since: float = 0.0
    _counting: bool = False

    def begin_cycle(self, cycle: int) -> None:
        """Count this cycle, or not: the counting itself costs."""
        self._counting = cycle % _COUNTED_EVERY == 0
        self._since = time.perf_counter() if self._counting else 0.0

    def spent_on(self, part: str) -> None:
        """What has passed since the last call went into `part`."""
        if self._counting:
            now = time.perf_counter()
            self.seconds[part] = self.seconds.get(part, 0.0) + _COUNTED_EVERY * (now - self._since)
            self._since = now


class _VirtualSupervisor:
    """The supervisor's cycles in virtual time: one frame after the other, each taking a fixed time."""

    def __init__(
        self, configuration: Configuration, camera: VirtualCamera, noise_std_px: float, images: bool
    ) -> None:
        self._camera = camera
        self._exchange = SupervisorExchange(
            DEMO_KEY, _SUPERVISOR_SESSION, configuration.supervisor.cycles_in_flight
        )
        self._tracker = Supervisor(configuration.supervisor.tracker) if images else None
        self._variance = noise_std_px**2
        self._zero_px: float | None = None
        self._free_at_s = -inf
        self._started = False
        self._triggered = camera.triggered
        self._in_flight = configuration.supervisor.cycles_in_flight
        self._last_frame_s = -inf
        self._sent: deque[tuple[float, bytes]] = deque()

    def advance(self, now_s: float, timestamp: Callable[[], bytes]) -> tuple[list[bytes], list[Delivery]]:
        """Do what falls due up to `now_s`; `timestamp` gives the latest before it, the only one that is looked at.

        Returns the datagrams that arrive at the controller by then, and the frames that the camera handed over.
        """
        if not self._started:
            self._started = True
            self._begin_cycles(now_s, timestamp)
            self._last_frame_s = now_s
        delivered = self._camera.due(now_s)
        if delivered:
            self._last_frame_s = now_s
        elif self._triggered and now_s >= self._last_frame_s + ASK_AGAIN_S:
            self._last_frame_s = now_s
            for _ in range(self._in_flight):
                self._camera.request(now_s)
        for delivery in delivered:
            self._begin_cycles(now_s, timestamp)
            sample = self._sample(delivery, self._exchange.oldest().cycle)
            self._free_at_s = max(self._free_at_s, delivery.truth.delivered_s) + _PROCESSING_S
            self._sent.append((self._free_at_s, self._exchange.end_cycle(sample)))
        arrived = []
        while self._sent and self._sent[0][0] <= now_s:
            arrived.append(self._sent.popleft()[1])
            self._begin_cycles(now_s, timestamp)  # the next image is asked for as soon as this one is done
        return arrived, delivered

    def _begin_cycles(self, now_s: float, timestamp: Callable[[], bytes]) -> None:
        self._exchange.take([timestamp()])
        begun = self._exchange.begin_cycles()
        if self._triggered:
            for _ in range(begun):
                self._camera.request(now_s)

    def _sample(self, delivery: Delivery, started_cycle: int) -> VisualSample:
        if self._tracker is not None:
            return self._tracker.step(delivery.as_frame(), started_cycle)
        displacement = self._camera.tracked_displacement(delivery.truth.frame)
        if self._zero_px is None:
            self._zero_px = displacement
        return VisualSample(
            delivery.truth.frame,
            started_cycle,
            TrackingStatus.MEASURED,
            displacement - self._zero_px,
            0.0,
            0.0,
            self._variance,
            self._variance,
            0.0,
            0.0,
            nan if delivery.stamp_s is None else delivery.stamp_s,
            delivery.exposure_s,
            100,
            100,
        )


@dataclass
class VirtualRun:
    """One simulation: the true model, what the controller assumes, what happens, and the seed."""

    configuration: Configuration
    true_model: Model
    assumed_model: Model
    scenario: Scenario
    seed: int
    images: bool = False
    name: str = "model"


class _VirtualDrive:
    """The plant under the controller's commands, by way of a velocity loop where its joint obeys none."""

    def __init__(self, plant: Plant, run: VirtualRun) -> None:
        self._plant = plant
        kind, assumed = run.true_model.drive.kind, run.assumed_model.drive.kind
        if (kind == "velocity") != (assumed == "velocity"):
            raise UserError(
                f'{run.name}: drive.kind = "{kind}" of the rig and "{assumed}" of the controller\'s model: neither '
                "obeys what is meant for the other; give both models the same kind"
            )
        self._loop = None if kind == "velocity" else VelocityLoop(run.assumed_model, run.name)

    def advance(self, read: CycleInput, command_rad_s: float) -> None:
        """Move on by a cycle."""
        if self._loop is None:
            self._plant.advance(command_rad_s)
            return
        state = JointState(read.joint_position_rad, read.joint_velocity_rad_s, read.joint_age_s)
        self._plant.advance(self._loop.input_for(command_rad_s, state))


def simulate(
    run: VirtualRun,
    recording: MessageSink,
    truth: MessageSink,
    progress: Callable[[float], None] = lambda done: None,
) -> PartCosts:
    """Run the loop and write both files; returns what each part cost. Raises UserError for what cannot be simulated."""
    check_effects(run.true_model.effects, run.name)
    true_model = declared(run.true_model)
    cycle_s = true_model.timing.cycle_s
    refuse_step_of_absent_stamps(true_model, run.configuration.rig, run.name)
    plant = Plant(true_model, run.name)
    signal = AccelerometerSignal(
        true_model.accelerometer,
        cycle_s,
        np.random.default_rng((run.seed, ACCELEROMETER_STREAM)),
        accelerometer_effects(true_model, cycle_s, run.seed),
    )
    clock_steps = ClockSteps(true_model)
    disturbance = Disturbance(
        run.scenario,
        len(true_model.arm.modes),
        cycle_s,
        np.random.default_rng((run.seed, DISTURBANCE_STREAM)),
    )
    poses = PoseHistory(None)
    camera = VirtualCamera(true_model, run.configuration.rig, run.seed, poses, images=run.images)
    supervisor = _VirtualSupervisor(run.configuration, camera, true_model.camera.noise_std_px, run.images)
    controller = Controller(run.assumed_model, run.configuration.controller, run.name)
    drive = _VirtualDrive(plant, run)
    exchange = ControllerExchange(DEMO_KEY, _CONTROLLER_SESSION)
    exchange.expect(_SUPERVISOR_SESSION)
    read_accelerometer = accelerometer_reading(run.configuration.accelerometer, cycle_s)
    costs = PartCosts()
    cycles = round(run.scenario.duration_s / cycle_s)
    try:
        for cycle in range(cycles):
            costs.begin_cycle(cycle)
            now = cycle * cycle_s
            felt = signal.sample(plant.tip_acceleration_m_s2, now, plant.tip_angle_rad)
            acceleration = read_accelerometer(felt)
            costs.spent_on("accelerometer")
            poses.append(now, plant.tip_position_m, plant.tip_angle_rad)
            datagrams, delivered = supervisor.advance(now, partial(exchange.timestamp, max(0, cycle - 1)))
            costs.spent_on("camera and supervisor")
            read = CycleInput(
                cycle,
                acceleration,
                plant.encoder_position_rad,
                plant.encoder_velocity_rad_s,
                0.0,
                run.scenario.reference_rad_s(now),
                run.scenario.damping_allowed(now),
                exchange.take(datagrams, cycle),
            )
            costs.spent_on("exchange")
            answered = controller.step(read)
            costs.spent_on("controller")
            recording.write("/fast", clock_steps.row(fast_sample(read, answered, cycle_s)))
            recording.write("/estimate", clock_steps.row(estimate_sample(cycle, answered, cycle_s)))
            for sample in read.samples:
                recording.write("/frames", clock_steps.frame(frame_sample(sample, cycle, cycle_s)))
            truth.write("/truth/state", true_state(plant, now))
            for delivery in delivered:
                truth.write("/truth/frames", delivery.truth)
            costs.spent_on("recording")
            for strike in disturbance.act_on(plant, now):
                truth.write("/log", strike_line(strike, now))
            drive.advance(read, answered.command_rad_s)
            costs.spent_on("plant")
            if cycle % _REPORT_EVERY == 0:
                progress(cycle / cycles)
    finally:
        poses.close()
    return costs
