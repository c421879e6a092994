"""The serial accelerometers as tables: frames, start commands, rate, range, delay.

The start commands are sent at every start and are not saved in the device. delay_s is the filter's delay plus the time
of a frame on the serial line at the usual baud rate.
"""

from dataclasses import dataclass
from functools import reduce

from stillarm.drivers.accelerometers.register_tables.register_table import first_order_delay_s
from stillarm.drivers.accelerometers.serial_decoders.framing import Framing
from stillarm.drivers.accelerometers.serial_decoders.microcontroller import MICROCONTROLLER
from stillarm.drivers.accelerometers.serial_decoders.vectornav import VECTORNAV
from stillarm.drivers.accelerometers.serial_decoders.witmotion import WITMOTION
from stillarm.drivers.accelerometers.serial_decoders.xsens import XSENS
from stillarm.drivers.standard_gravity import STANDARD_GRAVITY_M_S2


@dataclass(frozen=True)
class Command:
    """Bytes to send, and how long to wait afterwards."""

    data: bytes
    wait_s: float = 0.02


@dataclass(frozen=True)
class SerialDevice:
    """One kind of device. resolution_m_s2: step of its numbers; 0: floats. noise_std_m_s2: of one sample."""

    name: str
    framing: Framing
    baud: int
    rate_hz: float
    delay_s: float
    range_m_s2: float
    resolution_m_s2: float
    noise_std_m_s2: float
    set_up: tuple[Command, ...]


def _on_line_s(frame_bytes: int, baud: int) -> float:
    return 10.0 * frame_bytes / baud  # start bit, eight bits, stop bit


def _xsens(message: int, data: bytes = b"") -> bytes:
    body = bytes((0xFF, message, len(data))) + data
    return b"\xfa" + body + bytes((-sum(body) & 0xFF,))


def _vectornav(text: str) -> bytes:
    checksum = reduce(lambda a, b: a ^ b, text.encode())
    return f"${text}*{checksum:02X}\r\n".encode()


_WITMOTION = SerialDevice(
    name="WitMotion",
    framing=WITMOTION,
    baud=115200,
    rate_hz=200.0,
    # Its 188 Hz filter is the MPU-6050's, 2.0 ms; the factory setting is 20 Hz.
    delay_s=2.0e-3 + _on_line_s(11, 115200),
    range_m_s2=16.0 * STANDARD_GRAVITY_M_S2,
    resolution_m_s2=16.0 * STANDARD_GRAVITY_M_S2 / 32768.0,
    noise_std_m_s2=0.01 * STANDARD_GRAVITY_M_S2,
    set_up=(
        Command(bytes.fromhex("FFAA6988B5"), 0.1),  # unlock
        Command(bytes.fromhex("FFAA1F0100"), 0.1),  # filter of 188 Hz
        Command(bytes.fromhex("FFAA020200"), 0.1),  # accelerations only
        Command(bytes.fromhex("FFAA030B00"), 0.1),  # 200 Hz
    ),
)

_XSENS = SerialDevice(
    name="Xsens MTi",
    framing=XSENS,
    baud=921600,
    rate_hz=1000.0,
    # No filter delay is stated for the high-rate output. This is the line's alone; measure and correct it.
    delay_s=_on_line_s(32, 921600),
    range_m_s2=10.0 * STANDARD_GRAVITY_M_S2,
    resolution_m_s2=0.0,
    noise_std_m_s2=60e-6 * STANDARD_GRAVITY_M_S2 * 500.0**0.5,
    set_up=(
        Command(_xsens(0x30), 0.1),  # to configuration
        # counter and fine time with every sample; high-rate acceleration at 1000 Hz, in single precision
        Command(_xsens(0xC0, bytes.fromhex("1020FFFF 1060FFFF 404003E8")), 0.1),
        Command(_xsens(0x10), 0.1),  # to measurement
    ),
)

_VECTORNAV = SerialDevice(
    name="VectorNav",
    framing=VECTORNAV,
    baud=921600,
    rate_hz=800.0,
    # A first-order lag of the accelerometer's stated bandwidth of 260 Hz, plus the line.
    delay_s=first_order_delay_s(260.0) + _on_line_s(26, 921600),
    range_m_s2=16.0 * STANDARD_GRAVITY_M_S2,
    resolution_m_s2=0.0,
    noise_std_m_s2=140e-6 * STANDARD_GRAVITY_M_S2 * 260.0**0.5,
    set_up=(
        Command(_vectornav("VNWRG,06,0"), 0.05),  # no text
        # binary output 1: both ports, every sample; common group: time since start-up, acceleration
        Command(_vectornav("VNWRG,75,3,1,01,0101"), 0.05),
    ),
)

_MICROCONTROLLER = SerialDevice(
    name="microcontroller",
    framing=MICROCONTROLLER,
    baud=460800,
    rate_hz=1000.0,
    delay_s=_on_line_s(24, 460800),  # until it describes its sensor
    range_m_s2=2000.0,
    resolution_m_s2=1e-6,
    noise_std_m_s2=0.0,
    set_up=(),
)

SERIAL_DEVICES: dict[str, SerialDevice] = {
    "witmotion": _WITMOTION,
    "xsens": _XSENS,
    "vectornav": _VECTORNAV,
    "microcontroller": _MICROCONTROLLER,
}
