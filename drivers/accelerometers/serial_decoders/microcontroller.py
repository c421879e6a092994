"""The stream of a user's microcontroller, as docs/serial-stream.md defines it: 24-byte frames with a CRC.

A5 5A, kind, status, counter, device time in us, three numbers, CRC (polynomial 0x1021, initial value 0, high byte
first) of all between. Kind 1, a sample: acceleration in um/s^2. Kind 2, a description: rate in mHz, range in um/s^2,
delay in us.
"""

import binascii
import struct

from stillarm.drivers.accelerometers.serial_decoders.framing import Description, Framing, SerialSample

SYNC = b"\xa5\x5a"
SAMPLE, DESCRIPTION = 1, 2
SENSOR_FAULT, CLIPPED = 0x01, 0x02  # bits of the status
LENGTH = 24
_LAYOUT = struct.Struct("<2xBBHI3i2x")


def _valid(frame: bytes) -> bool:
    return binascii.crc_hqx(frame[2:], 0) == 0


def _sample(frame: bytes) -> SerialSample | None:
    kind, status, counter, time_us, x, y, z = _LAYOUT.unpack(frame)
    if kind != SAMPLE or status & SENSOR_FAULT:
        return None
    return SerialSample(x * 1e-6, y * 1e-6, z * 1e-6, counter, status, time_us * 1e-6)


def _describe(frame: bytes) -> Description | None:
    """The description in a valid frame; None for a frame of another kind."""
    kind, _, _, _, rate_mhz, range_um_s2, delay_us = _LAYOUT.unpack(frame)
    if kind != DESCRIPTION:
        return None
    return Description(rate_mhz * 1e-3, range_um_s2 * 1e-6, delay_us * 1e-6)


MICROCONTROLLER = Framing(SYNC, LENGTH, lambda buffer, at: LENGTH, _valid, _sample, _describe)
