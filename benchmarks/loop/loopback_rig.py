"""What a controller's devices talk to, on loopback and in the caller's thread: registers, gateway, supervisor.

The controller's own devices run as on a rig: its sockets, its driver of the accelerometer, its drive. The vibration is
steady, so that each cycle has its ordinary work to do.
"""

import secrets
import threading
import time
from math import cos, pi

import msgspec
import numpy as np

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import (
    Configuration,
    default_configuration_path,
    load_assumed_model,
    load_configuration,
)
from stillarm.common.files.model import Model
from stillarm.common.link.free_ports import free_ports
from stillarm.common.link.link_key import load_key
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.controller.loop.live_devices import LiveDevices
from stillarm.drivers.drives.drive_gateway import DriveGateway
from stillarm.drivers.drives.drive_gateway_socket import DriveGatewaySocket
from stillarm.drivers.emulation.emulated_accelerometer import emulate_accelerometer
from stillarm.supervisor.exchange import SupervisorExchange

_AMPLITUDE_M = 0.006
_NOISES = 4099  # a prime: the noise does not repeat with the vibration
_IN_FLIGHT = 4  # buffers of the simulated camera (configs/simulated_rig.toml)
_MOST_DATAGRAMS = 16
_PUBLISHED_EVERY_S = 0.001


def loopback_configuration() -> tuple[Configuration, Model]:
    """configs/default.toml on free ports, with an emulated accelerometer, armed; and its model."""
    path = default_configuration_path()
    configuration = load_configuration(path)
    replace, ports = msgspec.structs.replace, free_ports(5)
    link = replace(
        configuration.link, controller_port=ports[0], supervisor_port=ports[1], reference_port=ports[2]
    )
    return replace(
        configuration,
        link=link,
        drive=replace(configuration.drive, gateway_port=ports[3], local_port=ports[4]),
        accelerometer=replace(
            configuration.accelerometer, bus=f"memory:latency-{secrets.token_hex(4)}", axis="y"
        ),
        controller=replace(configuration.controller, arm_at_start=True),
    ), load_assumed_model(configuration, path)


class LoopbackRig:
    """advance() once between two cycles: the controller's datagrams are answered, its registers have a new sample."""

    def __init__(self, configuration: Configuration, model: Model) -> None:
        """Open sockets and registers. Raises UserError."""
        self._model, self._cycle_s = model, model.timing.cycle_s
        link, drive, key = configuration.link, configuration.drive, load_key(configuration.link)
        self._registers = emulate_accelerometer(configuration.accelerometer, self._cycle_s)
        self._drive = DriveGateway(key)
        self._gateway = DriveGatewaySocket(self._drive, (drive.gateway_host, drive.gateway_port))
        self._socket = UdpSocket((link.supervisor_host, link.supervisor_port), "link.supervisor_port")
        self._exchange = SupervisorExchange(key, new_session(), _IN_FLIGHT)
        self._controller = (link.controller_host, link.controller_port)
        self._frame_s = 1.0 / model.camera.frame_rate_hz
        self._w = model.arm.modes[0].angular_frequency
        noise = np.random.default_rng(0).normal(0.0, model.accelerometer.noise_std_m_s2, _NOISES)
        self._noise_m_s2: list[float] = noise.tolist()
        self._frame = 0
        self._position_rad = 0.0

    def start(self, devices: LiveDevices) -> None:
        """Start the controller's devices, which wait for samples: these are published meanwhile. Raises UserError."""
        started = threading.Event()

        def publish() -> None:
            while not started.wait(_PUBLISHED_EVERY_S):
                self._registers.publish((0.0, 0.0, 0.0))

        publishing = threading.Thread(target=publish)
        publishing.start()
        try:
            devices.start()
        finally:
            started.set()
            publishing.join()

    def advance(self, cycle: int) -> None:
        """What happens before `cycle`: a sample, the joint's state, and at the frame rate an image."""
        now_s, w = cycle * self._cycle_s, self._w
        of_tip = -w * w * self._deflection_m(now_s)
        felt = self._model.accelerometer.scale * of_tip + self._noise_m_s2[cycle % _NOISES]
        self._registers.publish((0.0, felt, 0.0))
        velocity_rad_s = self._gateway.poll(time.monotonic())
        self._position_rad += velocity_rad_s * self._cycle_s
        self._gateway.report(self._position_rad, velocity_rad_s)
        self._exchange.take(self._socket.drain(_MOST_DATAGRAMS), time.monotonic())
        self._exchange.begin_cycles()
        if now_s >= self._frame * self._frame_s:
            self._send_image(now_s)

    def _send_image(self, now_s: float) -> None:
        """The image that was exposed a capture delay ago."""
        camera = self._model.camera
        deflection = self._deflection_m(now_s - self._model.timing.capture_delay_s)
        variance = camera.noise_std_px**2
        sample = VisualSample(
            self._frame,
            self._exchange.oldest().cycle,
            TrackingStatus.MEASURED,
            -camera.scale_px_per_m * deflection,
            0.0,
            0.0,
            variance,
            variance,
        )
        self._frame += 1
        self._socket.send(self._exchange.end_cycle(sample, time.monotonic()), self._controller)

    def _deflection_m(self, time_s: float) -> float:
        return _AMPLITUDE_M * cos(self._w * time_s % (2.0 * pi))

    def close(self) -> None:
        """Release everything."""
        self._gateway.close()
        self._socket.close()
        self._registers.close()
