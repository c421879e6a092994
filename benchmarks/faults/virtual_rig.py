"""A rig in virtual time in which every part can fail: link and drive link over wires, real exchanges, driver, gateway.

One call of step() is one millisecond. The controller, the supervisor and the gateway can be stopped, continued, killed
and restarted, each with a new session. The arm is struck repeatedly, so that there is always a vibration to damp.
"""

import os
from collections import deque
from dataclasses import replace
from math import inf, nan

import msgspec
import numpy as np

from stillarm.benchmarks.faults.faulty_link import Wire
from stillarm.common.datagrams.datagram import DEMO_KEY, Peer
from stillarm.common.datagrams.messages import DriveCommand, DriveState, Hello
from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.exchange import ControllerExchange, oldest_sample_s
from stillarm.controller.loop.step import Controller
from stillarm.drivers.accelerometers.i2c_accelerometer import I2cAccelerometer
from stillarm.drivers.accelerometers.mounting import sensed_axes
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.cameras.camera import Frame
from stillarm.drivers.drives.drive_gateway import DriveGateway
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer
from stillarm.simulation.arm.plant import Plant
from stillarm.simulation.camera.pose_history import PoseHistory
from stillarm.simulation.camera.virtual_camera import Delivery, VirtualCamera
from stillarm.simulation.sensors.accelerometer_signal import AccelerometerSignal
from stillarm.supervisor.exchange import SupervisorExchange
from stillarm.supervisor.step import Supervisor

CYCLE_S = 0.001
STRIKE_EVERY = 400  # cycles
STRIKE_M = 0.004
_PROCESSING_S = 0.004
_ACCELEROMETER_WORD = "faults"


class _DriveEnd:
    """The controller's side of the drive link: stillarm.drivers.drives.udp_gateway_drive without its socket."""

    def __init__(self, session: int) -> None:
        self._peer = Peer(DEMO_KEY, (DriveState, Hello), session)
        self.position = self.velocity = nan
        self.arrived_s = -inf

    def take(self, datagrams: list[bytes], now_s: float) -> None:
        for data in datagrams:
            datagram = self._peer.receive(data)
            if datagram is not None and isinstance(datagram.body, DriveState):
                self.position, self.velocity = datagram.body.position_rad, datagram.body.velocity_rad_s
                self.arrived_s = now_s

    def command(self, velocity_rad_s: float) -> bytes:
        return self._peer.encode(DriveCommand(velocity_rad_s))


class VirtualRig:
    """All parts from the arm to its command."""

    def __init__(
        self, configuration: Configuration, model: Model, seed: int, *, images: bool = False
    ) -> None:
        """images: render and track images; otherwise the true displacement with noise stands in for the tracker."""
        self.configuration, self.model = configuration, model
        self.cycle = 0
        self._images = images
        self._session = 1 << 62
        self._plant = Plant(model)
        self._random = np.random.default_rng((seed, 0xFA17))
        self._signal = AccelerometerSignal(model.accelerometer, CYCLE_S, np.random.default_rng((seed, 1)))
        name = f"{_ACCELEROMETER_WORD}-{os.getpid()}-{seed}-{id(self):x}"
        device = msgspec.structs.replace(configuration.accelerometer, bus=f"memory:{name}")
        self._device = device
        self.accelerometer = emulate_accelerometer(device, CYCLE_S)
        self._driver = I2cAccelerometer(
            device,
            TABLES[device.driver],
            wait_s=0.0,
            sleep=lambda s: None,
            clock=lambda: self.cycle * CYCLE_S,
        )
        self._driver.start()
        self._poses = PoseHistory(None)
        self.camera = VirtualCamera(model, configuration.rig, seed, self._poses, images=images)
        self.up, self.down = Wire(seed * 4), Wire(seed * 4 + 1)  # visual data to the controller; timestamps
        self.commands, self.states = Wire(seed * 4 + 2), Wire(seed * 4 + 3)
        self.camera_stalled = False
        self.spoil_frame = 0  # number of following images that `spoil` affects
        self.spoil = "flash"
        self.clock_step_s = 0.0
        self.damping_allowed = True
        self.controller_runs = self.supervisor_runs = self.gateway_runs = True
        self._last_image: Frame | None = None
        self.start_controller()
        self.start_supervisor()
        self.start_gateway()
        self.command_rad_s = 0.0  # the command that the gateway follows, which is judged
        self.damping_rad_s = 0.0

    def _new_session(self) -> int:
        self._session += 1
        return self._session

    def start_controller(self) -> None:
        """Start as the process does: everything is new except the configuration."""
        session = self._new_session()
        oldest_s = oldest_sample_s(self.model, self.configuration.supervisor.cycles_in_flight)
        self._controller = Controller(self.model, self.configuration.controller)
        self.exchange = ControllerExchange(DEMO_KEY, session, round(oldest_s / CYCLE_S))
        self.drive = _DriveEnd(self._new_session())
        self._origin = self.cycle
        self.controller_runs = True

    def start_supervisor(self) -> None:
        """Start as the process does."""
        in_flight = self.configuration.supervisor.cycles_in_flight
        self.supervisor_exchange = SupervisorExchange(DEMO_KEY, self._new_session(), in_flight)
        self._tracker = Supervisor(self.configuration.supervisor.tracker) if self._images else None
        self._zero_px: float | None = None
        self._sending: deque[tuple[float, bytes]] = deque()
        self._no_image_s = -inf
        self.supervisor_runs = True

    def start_gateway(self) -> None:
        """Start as the drive's side does when its power returns."""
        self.gateway = DriveGateway(DEMO_KEY, self._new_session())
        self.gateway_runs = True

    def step(self) -> None:
        """Advance all parts by one millisecond."""
        now = self.cycle * CYCLE_S
        plant = self._plant
        self.accelerometer.publish(
            sensed_axes(self._signal.sample(plant.tip_acceleration_m_s2), self._device)
        )
        self._poses.append(now, plant.tip_position_m, plant.tip_angle_rad)
        self._supervise(now)
        if self.controller_runs:
            self._control(now)
        if self.gateway_runs:
            self._gate(now)
        velocity = self.gateway.velocity_command(now) if self.gateway_runs else 0.0
        self.command_rad_s = velocity
        if self.cycle % STRIKE_EVERY == 0:
            plant.strike(1, float(self._random.choice((-STRIKE_M, STRIKE_M))))
        plant.advance(velocity)
        self.cycle += 1

    def _control(self, now: float) -> None:
        cycle = self.cycle - self._origin
        self.down.send(self.exchange.timestamp(cycle, now), now)
        acceleration = self._driver.read()
        self.drive.take(self.states.arrived(now), now)
        samples = self.exchange.take(self.up.arrived(now), cycle, now)
        answered = self._controller.step(
            CycleInput(
                cycle,
                acceleration,
                self.drive.position,
                self.drive.velocity,
                min(now - self.drive.arrived_s, 1e6),
                0.0,
                self.damping_allowed,
                samples,
            )
        )
        self.damping_rad_s = answered.damping_rad_s
        self.commands.send(self.drive.command(answered.command_rad_s), now)

    def _gate(self, now: float) -> None:
        for data in self.commands.arrived(now):
            if not self.gateway.receive(data, now) and (hello := self.gateway.hello()):
                self.states.send(hello, now)
        if self.gateway.counts.accepted:
            plant = self._plant
            self.states.send(
                self.gateway.state_datagram(plant.joint_position_rad, plant.joint_velocity_rad_s), now
            )

    def _supervise(self, now: float) -> None:
        delivered = self.camera.due(now)
        if not self.supervisor_runs:
            return
        exchange = self.supervisor_exchange
        there = now + self.clock_step_s
        exchange.take(self.down.arrived(now), there)
        exchange.begin_cycles()
        if self.camera_stalled:
            if now - self._no_image_s >= 0.1:
                self._no_image_s = now
                sample = VisualSample(-1, exchange.oldest().cycle, TrackingStatus.NO_IMAGE)
                self._sending.append((now, exchange.end_cycle(sample, there)))
        else:
            for delivery in delivered:
                sample = self._sample(delivery, exchange.oldest().cycle)
                self._sending.append((now + _PROCESSING_S, exchange.end_cycle(sample, there)))
                exchange.begin_cycles()
        while self._sending and self._sending[0][0] <= now:
            self.up.send(self._sending.popleft()[1], now)

    def _sample(self, delivery: Delivery, started: int) -> VisualSample:
        if self._tracker is not None:
            return self._tracker.step(self._frame(delivery), started)
        frame = delivery.truth.frame
        displacement = self.camera.tracked_displacement(frame)
        if self._zero_px is None:
            self._zero_px = displacement
        displacement -= self._zero_px
        variance = self.model.camera.noise_std_px**2
        if self.spoil_frame > 0:
            self.spoil_frame -= 1
            displacement = {"nan": nan, "infinite": inf, "wild": float(self._random.normal(0.0, 80.0))}[
                self.spoil
            ]
        stamp = nan if delivery.stamp_s is None else delivery.stamp_s + self.clock_step_s
        return VisualSample(
            frame, started, 0, displacement, 0.0, 0.0, variance, variance, 0.0, 0.0,
            stamp, delivery.exposure_s, 100, 100,
        )  # fmt: skip

    def _frame(self, delivery: Delivery) -> Frame:
        frame = delivery.as_frame()
        if self.spoil_frame > 0:
            self.spoil_frame -= 1
            image = frame.image
            if self.spoil == "flash":
                image = np.full_like(image, 255)
            elif self.spoil == "dark":
                image = np.zeros_like(image)
            elif self.spoil == "noise":
                image = self._random.integers(0, 256, image.shape, dtype=np.uint8)
            elif self.spoil == "frozen" and self._last_image is not None:
                image = self._last_image.image
            frame = replace(frame, image=image)
        self._last_image = replace(frame, image=frame.image.copy())
        return frame

    def close(self) -> None:
        """Release the shared memory."""
        self._driver.close()
        self.accelerometer.close()
        self._poses.close()
