"""The controller's devices and sockets: what a cycle reads and writes on a rig."""

import time
from math import nan

from stillarm.common.datagrams.messages import Adjustment, OperatorCommand, Reference, Visual
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario, load_scenario
from stillarm.common.link.link_key import load_key
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.process.stop_signal import SignalFlag
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.exchange import ControllerExchange, ReferenceExchange, oldest_sample_s
from stillarm.controller.input.operator_input import OperatorInput
from stillarm.drivers.accelerometers.accelerometer_factory import held_samples_statement, open_accelerometer
from stillarm.drivers.drives.drive_factory import open_drive
from stillarm.drivers.drives.udp_gateway_drive import UdpGatewayDrive

_EXPECTED_PER_CYCLE = 2  # datagrams of a peer that means well
_MOST_QUEUED = 10_000  # datagrams, more than a buffer holds: a flood must not keep the start from ending
Sensed = tuple[float, float, float, float]
"""Acceleration, m/s^2; the joint's position, rad, velocity, rad/s, and age, s. NaN where there is no such device."""
_OLDEST_S = 1e6  # a drive that never reported: an infinite age would not survive a recording


class LiveDevices:
    """Accelerometer, drive, link to the supervisor and reference, as one thing to read from and write to."""

    def __init__(
        self,
        configuration: Configuration,
        model: Model,
        emergency_signal: SignalFlag | None = None,
        model_name: str = "model",
    ) -> None:
        """Opens nothing; start() does. emergency_signal: stops the arm when it comes. model_name: stands for the
        model's file in messages.
        """
        self._configuration = configuration
        self._cycle_s = cycle_s = model.timing.cycle_s
        link = configuration.link
        key = load_key(link)
        self.session = new_session()
        oldest_s = oldest_sample_s(model, configuration.supervisor.cycles_in_flight)
        self._exchange = ControllerExchange(key, self.session, round(oldest_s / cycle_s))
        self._reference = ReferenceExchange(key, self.session)
        self._accelerometer = open_accelerometer(configuration.accelerometer)
        self._drive = open_drive(configuration.drive, key, model, model_name)
        self._operator = OperatorInput(configuration.controller.safety, emergency_signal)
        schedule = configuration.controller.schedule
        self._schedule: Scenario | None = load_scenario(schedule) if schedule else None
        self._supervisor = (link.supervisor_host, link.supervisor_port)
        self._limit = link.max_datagrams_per_cycle
        self._sockets: list[UdpSocket] = []
        self.notes: list[str] = []
        """What the user is to know of the devices once they are open."""

    def start(self) -> None:
        """Open sockets and devices. Moves nothing. Raises UserError with a remedy."""
        link = self._configuration.link
        self._sockets = [
            UdpSocket((link.controller_host, link.controller_port), "link.controller_port"),
            UdpSocket((link.controller_host, link.reference_port), "link.reference_port"),
        ]
        for socket, takes in zip(
            self._sockets, ((Visual,), (Reference, OperatorCommand, Adjustment)), strict=True
        ):
            socket.guard(takes, self.session, _EXPECTED_PER_CYCLE)
        self._operator.start()
        if self._accelerometer is not None:
            self._accelerometer.start()
            statement = held_samples_statement(self._accelerometer, self._cycle_s)
            if statement is not None:
                self.notes.append(statement)
        if self._drive is not None:
            self._drive.start()

    def empty_queues(self) -> None:
        """Drop the visual samples that came before cycle 0. What an operator has sent stays.

        They answer no timestamp of this run, and refusing them one by one would fill the first cycles.
        """
        data_socket = self._sockets[0]
        for _ in range(_MOST_QUEUED):
            if not data_socket.drain(1):
                break

    def read(self, cycle: int) -> CycleInput:
        """Open a cycle: send its timestamp, then read the accelerometer, the drive and what came by UDP."""
        return self.receive(cycle, self.sense(cycle))

    def sense(self, cycle: int) -> Sensed:
        """The first half of read(): send the timestamp, then read the accelerometer and the drive."""
        timestamp = self._exchange.timestamp(cycle, time.monotonic())
        self._sockets[0].send(timestamp, self._supervisor)
        acceleration = self._accelerometer.read() if self._accelerometer is not None else nan
        if self._drive is None:
            return acceleration, nan, nan, nan
        position, velocity, age = self._drive.state()
        return acceleration, position, velocity, min(age, _OLDEST_S)

    def receive(self, cycle: int, sensed: Sensed) -> CycleInput:
        """The second half of read(): take what came by UDP, and what an operator asks."""
        data_socket, reference_socket = self._sockets
        time_s = cycle * self._cycle_s
        acceleration, position, velocity, age = sensed
        for data, sender in reference_socket.drain_with_senders(self._limit):
            self._reference.take([data], time_s)
            if answer := self._reference.hello():
                reference_socket.send(answer, sender)
        reference, allowed = self._reference.reference(time_s)
        if self._schedule is not None:
            reference += self._schedule.reference_rad_s(time_s)
            allowed = allowed and self._schedule.damping_allowed(time_s)
        else:
            allowed = allowed and self._configuration.controller.damping.without_schedule
        samples = self._exchange.take(data_socket.drain(self._limit), cycle, time.monotonic())
        operator = self._reference.asked() | self._operator.asked()
        return CycleInput(
            cycle,
            acceleration,
            position,
            velocity,
            age,
            reference,
            allowed,
            samples,
            operator=operator,
            adjustment=self._reference.adjustment(),
        )

    def write(self, command_rad_s: float) -> None:
        """Send the command."""
        if self._drive is not None:
            self._drive.command(command_rad_s)

    @property
    def link_counts(self) -> dict[str, int]:
        """Counts of the visual datagrams, by name."""
        return self._exchange.count_by_name()

    def link_status(self) -> dict[str, float]:
        """What /link tells beside those counts, by the names of its fields: other sockets, clocks."""
        shed = sum(socket.shed for socket in self._sockets)
        failures = sum(socket.send_failures for socket in self._sockets)
        clock = self._exchange.clock.estimate
        status: dict[str, float] = {
            "reference_refused": self._reference.counts.refused,
            "supervisor_clock_offset_s": clock.offset_s,
            "supervisor_clock_offset_std_s": clock.offset_std_s,
            "supervisor_clock_skew": clock.skew,
            "round_trip_s": clock.round_trip_s,
        }
        drive = self._drive
        if isinstance(drive, UdpGatewayDrive):
            counts = drive.counts
            status |= {
                "drive_accepted": counts.accepted,
                "drive_lost": counts.lost,
                "drive_refused": counts.refused,
                "drive_ignored": drive.ignored,
                "drive_tripped": int(drive.tripped),
            }
            shed += drive.shed
            failures += drive.send_failures
        return status | {"shed": shed, "send_failures": failures}

    @property
    def accelerometer_faults(self) -> int:
        """Reads of the accelerometer that gave no sample."""
        return self._accelerometer.faults if self._accelerometer is not None else 0

    def close(self) -> None:
        """Command zero, release everything."""
        if self._drive is not None:
            self._drive.close()
        if self._accelerometer is not None:
            self._accelerometer.close()
        self._operator.close()
        for socket in self._sockets:
            socket.close()
