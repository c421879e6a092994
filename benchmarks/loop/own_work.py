"""The work of a controller's cycle without a rig: the step on a synthetic vibration, datagrams, recording."""

from math import cos, pi

import msgspec

from stillarm.common.datagrams.datagram import DEMO_KEY, Peer, encode
from stillarm.common.datagrams.messages import DriveCommand, Message, Timestamp, Visual
from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample, visual_message
from stillarm.common.files.configuration import Controller as ControllerSettings
from stillarm.common.files.model import Model
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.exchange import visual_sample
from stillarm.controller.loop.recorded import estimate_sample, fast_sample
from stillarm.controller.loop.step import Controller

_CYCLES_A_FRAME = 15  # 65 frames a second
_DELAY_CYCLES = 74  # the model's mean capture delay
_AMPLITUDE_M = 0.006


class OwnWork:
    """One call is one cycle: sends a timestamp and a command, receives images, steps, encodes the recorded messages."""

    def __init__(self, model: Model, settings: ControllerSettings) -> None:
        """Open a socket on loopback that sends to itself."""
        self._model, self._cycle_s = model, model.timing.cycle_s
        self._controller = Controller(model, msgspec.structs.replace(settings, arm_at_start=True))
        self._session = new_session()
        self._peer = Peer(DEMO_KEY, (Visual,))
        self._socket = UdpSocket(("127.0.0.1", 0), "latency")
        self._encode = msgspec.msgpack.Encoder().encode
        self._w = model.arm.modes[0].angular_frequency
        count = round(1.0 / model.arm.modes[0].frequency_hz / self._cycle_s)
        self._wave = [_AMPLITUDE_M * cos(2.0 * pi * n / count) for n in range(count)]
        self._cycle = self._sequence = 0

    def __call__(self) -> None:
        """Do a cycle's work."""
        cycle, model = self._cycle, self._model
        self._cycle += 1
        wave = self._wave
        self._send(Timestamp(cycle, cycle * self._cycle_s))
        if cycle % _CYCLES_A_FRAME == 0:
            seen = -model.camera.scale_px_per_m * wave[(cycle - _DELAY_CYCLES) % len(wave)]
            sample = VisualSample(
                cycle, max(0, cycle - _DELAY_CYCLES), TrackingStatus.MEASURED, seen, 0.0, 0.0, 0.01
            )
            self._send(visual_message(self._session, sample))
        acceleration = -model.accelerometer.scale * self._w * self._w * wave[cycle % len(wave)]
        samples = []
        for data in self._socket.drain(16):
            datagram = self._peer.receive(data)
            if datagram is not None:
                samples.append(visual_sample(datagram.body))
        step = CycleInput(cycle, acceleration, 0.0, 0.0, 0.0, 0.0, True, samples)
        answered = self._controller.step(step)
        self._send(DriveCommand(answered.command_rad_s))
        self._encode(fast_sample(step, answered, self._cycle_s))
        self._encode(estimate_sample(cycle, answered, self._cycle_s))

    def _send(self, body: Message) -> None:
        self._sequence += 1
        data = encode(DEMO_KEY, self._session, self._sequence, body)
        self._socket.send(data, self._socket.address)

    def close(self) -> None:
        """Release the socket."""
        self._socket.close()
