"""The description of an I2C accelerometer as a table, which one driver reads."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi

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


def first_order_delay_s(bandwidth_hz: float) -> float:
    """Group delay of a first-order lag at low frequency: 1 / (2 pi f). For parts whose data sheet states none."""
    return 1.0 / (2.0 * pi * bandwidth_hz)
