"""Emulated serial accelerometers with factory settings: their frames, and their reaction to commands."""

import struct
from collections.abc import Callable, Sequence
from typing import Protocol

from stillarm.drivers.emulation.serial_frames import (
    microcontroller_frame,
    vectornav_data,
    vectornav_text,
    witmotion_acceleration,
    witmotion_frame,
    xsens_data,
    xsens_message,
)

_DESCRIBE_EVERY = 500
_LARGEST_UM_S2 = 39_200_000  # what the microcontroller says that its sensor measures


class SerialSender(Protocol):
    """One device: sends frames of samples, receives commands. rate_hz: present sample rate."""

    rate_hz: float

    def frames(self, xyz_m_s2: Sequence[float], time_s: float) -> bytes:
        """The bytes of one sample."""

    def obey(self, data: bytes) -> bytes:
        """Process bytes from the driver. Returns the answer."""


class WitMotionSender:
    """10 Hz of acceleration, rotation and angle until it is unlocked and configured."""

    def __init__(self) -> None:
        self.rate_hz = 10.0
        self._content = 0x0E
        self._locked = True

    def frames(self, xyz_m_s2: Sequence[float], time_s: float) -> bytes:
        """Acceleration, and the other quantities of the content register."""
        x, y, z = xyz_m_s2
        sent = b""
        if self._content & 0x02:
            sent += witmotion_acceleration(x, y, z)
        if self._content & 0x04:
            sent += witmotion_frame(0x52, (1, -2, 3, 0))
        if self._content & 0x08:
            sent += witmotion_frame(0x53, (100, -200, 300, 0))
        return sent

    def obey(self, data: bytes) -> bytes:
        """FF AA register low high; there is no answer."""
        for at in range(0, len(data) - 4, 5):
            if data[at : at + 2] != b"\xff\xaa":
                continue
            register, value = data[at + 2], data[at + 3]
            if register == 0x69:
                self._locked = data[at + 3 : at + 5] != b"\x88\xb5"
            elif not self._locked and register == 0x02:
                self._content = value
            elif not self._locked and register == 0x03:
                self.rate_hz = {0x06: 10.0, 0x09: 100.0, 0x0B: 200.0}.get(value, self.rate_hz)
        return b""


class XsensSender:
    """Measures from power-up, 100 Hz of 0x4020, until it is configured; silent in configuration."""

    def __init__(self) -> None:
        self.rate_hz = 100.0
        self._measuring = True
        self._identifier = 0x4020
        self._counter = 0

    def frames(self, xyz_m_s2: Sequence[float], time_s: float) -> bytes:
        """One MTData2 message."""
        if not self._measuring:
            return b""
        self._counter += 1
        return xsens_data(xyz_m_s2, self._counter, round(time_s * 1e4), self._identifier)

    def obey(self, data: bytes) -> bytes:
        """Go to configuration, set the output, go to measurement; each is acknowledged."""
        answers = b""
        at = 0
        while at + 5 <= len(data) and data[at] == 0xFA:
            length = data[at + 3]
            message = data[at : at + length + 5]
            if sum(message[1:]) % 256 == 0:
                answers += self._answer(message[2], message[4:-1])
            at += length + 5
        return answers

    def _answer(self, identifier: int, payload: bytes) -> bytes:
        if identifier == 0x30:
            self._measuring = False
        elif identifier == 0x10:
            self._measuring = True
        elif identifier == 0xC0 and not self._measuring:
            for kind, rate in struct.iter_unpack(">HH", payload):
                if kind & 0xF000 == 0x4000:
                    self._identifier, self.rate_hz = kind, float(rate)
        else:
            return xsens_message(0x42, b"\x04")  # an error
        return xsens_message(identifier + 1, payload if identifier == 0xC0 else b"")


class VectorNavSender:
    """40 Hz of text until it is configured for binary output."""

    def __init__(self) -> None:
        self.rate_hz = 40.0
        self._text = True
        self._binary = False

    def frames(self, xyz_m_s2: Sequence[float], time_s: float) -> bytes:
        """Text, binary output, or both."""
        sent = vectornav_text("VNYPR,+010.071,+000.278,-002.026") if self._text else b""
        return sent + (vectornav_data(xyz_m_s2, round(time_s * 1e9)) if self._binary else b"")

    def obey(self, data: bytes) -> bytes:
        """Write the text output's register (6) and the first binary output's (75); each line is echoed."""
        answers = b""
        for line in data.decode("ascii", "replace").splitlines():
            text = line[1:].split("*")[0]
            if vectornav_text(text).decode().strip() != line.strip():
                continue
            fields = text.split(",")
            if fields[:2] == ["VNWRG", "06"]:
                self._text = fields[2] != "0"
            elif fields[:2] == ["VNWRG", "75"] and fields[4:] == ["01", "0101"]:
                self._binary, self.rate_hz = fields[2] != "0", 800.0 / float(fields[3])
            answers += vectornav_text(text)
        return answers


class MicrocontrollerSender:
    """Streams from power-up at 1 kHz, describing its sensor every half second."""

    def __init__(self) -> None:
        self.rate_hz = 1000.0
        self._counter = 0

    def frames(self, xyz_m_s2: Sequence[float], time_s: float) -> bytes:
        """A sample, at intervals preceded by a description."""
        limit, time_us = _LARGEST_UM_S2, round(time_s * 1e6)
        numbers = [min(max(round(a * 1e6), -limit), limit) for a in xyz_m_s2]
        clipped = any(abs(number) == limit for number in numbers)
        sent = b""
        if self._counter % _DESCRIBE_EVERY == 0:
            described = (round(self.rate_hz * 1e3), limit, 0)
            sent = microcontroller_frame(2, 0, self._counter, time_us, described)
        sent += microcontroller_frame(1, 2 if clipped else 0, self._counter, time_us, numbers)
        self._counter += 1
        return sent

    def obey(self, data: bytes) -> bytes:
        """Ignore commands."""
        return b""


SENDERS: dict[str, Callable[[], SerialSender]] = {
    "witmotion": WitMotionSender,
    "xsens": XsensSender,
    "vectornav": VectorNavSender,
    "microcontroller": MicrocontrollerSender,
}
