"""The description of an I2C accelerometer as a table, which one driver reads."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi

from stillarm.common.files.configuration import AccelerometerDevice
from stillarm.common.user_error import UserError

Counts = tuple[int, int, int]


@dataclass(frozen=True)
class Write:
    """One register to write, and how long to wait afterwards."""

    register: int
    value: int
    wait_s: float = 0.0


@dataclass(frozen=True)
class FilterSetting:
    """One setting of the low-pass filter. bits: added to the registers that set_up writes.

    bandwidth_hz: at -3 dB. delay_s: group delay at low frequency. count_step: counts are multiples of it if the
    words of the samples are left-justified.
    """

    bandwidth_hz: float
    rate_hz: float
    delay_s: float
    bits: Mapping[int, int]
    count_step: int = 1


@dataclass(frozen=True)
class FullScale:
    """One measuring range. max_count: counts lie in -max_count .. max_count - 1; bits: as for a filter."""

    counts_per_g: float
    max_count: int
    bits: Mapping[int, int]


@dataclass(frozen=True)
class Fifo:
    """A FIFO of samples. start: writes that switch it on; stop: that switch it off; depth: its size in samples.

    entries: number of whole samples in it, from the bytes of the count registers. rolling: one long read from
    data_register empties it; otherwise each sample needs a separate read.
    """

    start: tuple[Write, ...]
    stop: tuple[Write, ...]
    depth: int
    count_register: int
    count_length: int
    entries: Callable[[bytes], int]
    data_register: int
    sample_length: int
    decode: Callable[[bytes], Counts]
    rolling: bool
    marker: tuple[int, int] | None = None  # byte and bit that are set in a sample that begins with x


@dataclass(frozen=True)
class RegisterTable:
    """An accelerometer. Registers are written in the order of set_up, each with the bits of range and filter added.

    addresses: the usual one first. before_identity: writes that make the identity register visible. filters: the
    default first. status_register and data_register are read in one transfer, as one span if they are close together.
    ready_mask: bit of the status. noise_m_s2_per_sqrt_hz: white noise of one axis.
    """

    name: str
    addresses: tuple[int, ...]
    identity_register: int
    identity: bytes
    set_up: tuple[Write, ...]
    full_scales: Mapping[int, FullScale]
    filters: tuple[FilterSetting, ...]
    status_register: int
    data_register: int
    data_length: int
    decode: Callable[[bytes], Counts]
    ready_mask: int
    start_up_s: float
    noise_m_s2_per_sqrt_hz: float
    auto_increment: int = 0
    before_identity: tuple[Write, ...] = ()
    fifo: Fifo | None = None


def choose_full_scale(table: RegisterTable, device: AccelerometerDevice) -> FullScale:
    """The configured range. Raises UserError."""
    if device.full_scale_g not in table.full_scales:
        raise UserError(
            f"accelerometer.full_scale_g = {device.full_scale_g}: not a range of the {table.name}; "
            f"use {' or '.join(map(str, table.full_scales))}"
        )
    return table.full_scales[device.full_scale_g]


def choose_filter(table: RegisterTable, device: AccelerometerDevice) -> FilterSetting:
    """The configured filter, or the part's default for a bandwidth of 0. Raises UserError."""
    if device.bandwidth_hz == 0.0:
        return table.filters[0]
    for setting in table.filters:
        if abs(setting.bandwidth_hz - device.bandwidth_hz) <= 0.01 * setting.bandwidth_hz:
            return setting
    raise UserError(
        f"accelerometer.bandwidth_hz = {device.bandwidth_hz:g}: not a filter of the {table.name}; "
        f"use {' or '.join(f'{setting.bandwidth_hz:g}' for setting in table.filters)}, or 0 for the first of these"
    )


def choose_address(table: RegisterTable, device: AccelerometerDevice) -> int:
    """The configured address, or the part's usual one for 0. Raises UserError for an address that I2C reserves."""
    address = device.address or table.addresses[0]
    if address < 0x03:
        raise UserError(
            f"accelerometer.address = {address}: reserved on I2C; "
            f"the {table.name} has {' or '.join(f'0x{a:02x}' for a in table.addresses)}"
        )
    return address


def first_order_delay_s(bandwidth_hz: float) -> float:
    """Group delay of a first-order lag at low frequency: 1 / (2 pi f). For parts whose data sheet states none."""
    return 1.0 / (2.0 * pi * bandwidth_hz)
