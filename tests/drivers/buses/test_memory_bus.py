"""The emulated chip's registers and the emulated kernel's requests, seen from smbus2."""

import errno
import os
from collections.abc import Iterator
from typing import Any

import pytest
import smbus2
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.drivers.buses.i2c import open_bus
from stillarm.drivers.buses.i2c_adapter import I2cAdapter
from stillarm.drivers.emulated_chips.lis3lv02dq_chip import Lis3lv02dqChip
from stillarm.drivers.emulated_chips.lis3lv02dq_registers import LIS3LV02DQ_PART
from stillarm.drivers.emulated_chips.shared_registers import STANDARD_GRAVITY_M_S2, Failure, SensedRegisters

NAME = f"test-i2c-{os.getpid()}"
ADDRESS = 0x1D
CTRL1, CTRL2, STATUS, OUT = 0x20, 0x21, 0x27, 0x28
G = STANDARD_GRAVITY_M_S2


@pytest.fixture
def registers() -> Iterator[SensedRegisters]:
    made = SensedRegisters(NAME, LIS3LV02DQ_PART)
    yield made
    made.close()


@pytest.fixture
def bus(registers: SensedRegisters) -> Iterator[smbus2.SMBus]:
    with open_bus(f"memory:{NAME}") as opened:
        yield opened


def burst(bus: smbus2.SMBus, first: int, length: int) -> bytes:
    write, read = smbus2.i2c_msg.write(ADDRESS, [first]), smbus2.i2c_msg.read(ADDRESS, length)
    bus.i2c_rdwr(write, read)
    return bytes(read)


def put(bus: smbus2.SMBus, register: int, value: int) -> None:
    bus.write_byte_data(ADDRESS, register, value)


def get(bus: smbus2.SMBus, register: int) -> int:
    return int(bus.read_byte_data(ADDRESS, register))


def test_identity_and_state_after_power_up(bus: smbus2.SMBus) -> None:
    assert get(bus, 0x0F) == 0x3A
    assert (get(bus, CTRL1), get(bus, CTRL2), get(bus, STATUS)) == (0x07, 0x00, 0x00)


def test_powered_down_there_is_no_data(bus: smbus2.SMBus, registers: SensedRegisters) -> None:
    registers.publish((G, G, G))
    assert burst(bus, STATUS | 0x80, 7) == bytes(7)
    put(bus, CTRL1, 0xF7)
    registers.publish((G, G, G))
    assert burst(bus, STATUS | 0x80, 7) == b"\x0f" + b"\x00\x04" * 3
    put(bus, CTRL1, 0x07)
    registers.publish((0.0, 0.0, 0.0))
    assert burst(bus, STATUS | 0x80, 7) == b"\x00" + b"\x00\x04" * 3


def test_data_ready_and_overrun(bus: smbus2.SMBus, registers: SensedRegisters) -> None:
    put(bus, CTRL1, 0xF7)
    registers.publish((0.0, 0.0, 0.0))
    assert get(bus, STATUS) == 0x0F
    assert get(bus, STATUS) == 0x0F  # reading the status frees nothing
    registers.publish((0.0, 0.0, 0.0))
    assert get(bus, STATUS) == 0xFF
    burst(bus, (OUT + 2) | 0x80, 2)  # y alone
    assert get(bus, STATUS) == 0x01 | 0x04 | 0x10 | 0x40
    burst(bus, OUT | 0x80, 6)
    assert get(bus, STATUS) == 0x00


def test_a_disabled_axis_gives_no_data(bus: smbus2.SMBus, registers: SensedRegisters) -> None:
    put(bus, CTRL1, 0xF0 | 0x02)
    registers.publish((G, G, G))
    assert burst(bus, STATUS | 0x80, 7) == b"\x0a" + b"\x00\x00" + b"\x00\x04" + b"\x00\x00"


def test_auto_increment_only_where_it_is_asked_for(bus: smbus2.SMBus, registers: SensedRegisters) -> None:
    put(bus, CTRL1, 0xF7)
    registers.publish((G, 0.5 * G, -G))
    assert burst(bus, OUT | 0x80, 6) == b"\x00\x04\x00\x02\x00\xfc"
    assert burst(bus, OUT + 1, 3) == b"\x04\x04\x04"
    bus.i2c_rdwr(smbus2.i2c_msg.write(ADDRESS, [CTRL1 | 0x80, 0xD7, 0x44]))
    assert (get(bus, CTRL1), get(bus, CTRL2)) == (0xD7, 0x44)
    bus.i2c_rdwr(smbus2.i2c_msg.write(ADDRESS, [CTRL1, 0xC7, 0xF7]))
    assert (get(bus, CTRL1), get(bus, CTRL2)) == (0xF7, 0x44)


def test_the_pointer_stays_between_messages(bus: smbus2.SMBus) -> None:
    put(bus, CTRL2, 0x44)
    bus.i2c_rdwr(smbus2.i2c_msg.write(ADDRESS, [CTRL1 | 0x80]))
    first, second = smbus2.i2c_msg.read(ADDRESS, 1), smbus2.i2c_msg.read(ADDRESS, 1)
    bus.i2c_rdwr(first, second)
    assert (bytes(first), bytes(second)) == (b"\x07", b"\x44")
    assert burst(bus, 0x7F | 0x80, 17)[16] == 0x3A  # past the last register it goes on at the first


def test_identity_status_and_samples_cannot_be_written(bus: smbus2.SMBus, registers: SensedRegisters) -> None:
    put(bus, CTRL1, 0xF7)
    registers.publish((G, G, G))
    for register in (0x0F, STATUS, *range(OUT, OUT + 6)):
        put(bus, register, 0x55)
    assert get(bus, 0x0F) == 0x3A
    assert burst(bus, STATUS | 0x80, 7) == b"\x0f" + b"\x00\x04" * 3


@pytest.mark.parametrize(
    ("control2", "expected"),
    [
        (0x00, b"\x00\x02"),
        (0x20, b"\x02\x00"),
        (0x01, b"\x00\x20"),
        (0x21, b"\x20\x00"),
        (0x80, b"\xaa\x00"),
        (0xA1, b"\x0a\xa0"),
    ],
)
def test_range_byte_order_and_alignment(
    bus: smbus2.SMBus, registers: SensedRegisters, control2: int, expected: bytes
) -> None:
    put(bus, CTRL2, control2)
    put(bus, CTRL1, 0xF7)
    registers.publish((0.5 * G, 0.0, 0.0))
    assert burst(bus, OUT | 0x80, 2) == expected


@pytest.mark.parametrize("block_update", [True, False])
def test_block_update_keeps_an_axis_until_both_bytes_are_read(
    bus: smbus2.SMBus, registers: SensedRegisters, block_update: bool
) -> None:
    put(bus, CTRL2, 0x40 if block_update else 0x00)
    put(bus, CTRL1, 0xF7)
    registers.publish((255 * G / 1024, 0.0, 0.0))
    low = get(bus, OUT)
    registers.publish((256 * G / 1024, 256 * G / 1024, 0.0))
    high = get(bus, OUT + 1)
    assert high << 8 | low == (0x00FF if block_update else 0x01FF)
    assert burst(bus, (OUT + 2) | 0x80, 2) == b"\x00\x01"
    assert burst(bus, STATUS | 0x80, 3)[1:] == b"\x00\x01"


@pytest.mark.parametrize(("rate_bits", "taken"), [(0x00, 40), (0x10, 160), (0x20, 640), (0x30, 1000)])
def test_output_rate_of_samples_fed_at_1_khz(
    bus: smbus2.SMBus, registers: SensedRegisters, rate_bits: int, taken: int
) -> None:
    put(bus, CTRL1, 0xC7 | rate_bits)
    fresh = 0
    for _ in range(1000):
        registers.publish((0.0, 0.0, 0.0))
        fresh += burst(bus, STATUS | 0x80, 7)[0] & 0x08 == 0x08
    assert fresh == taken


def test_requests_of_smbus(bus: smbus2.SMBus) -> None:
    bus.write_quick(ADDRESS)
    bus.write_i2c_block_data(ADDRESS, CTRL1 | 0x80, [0xD7, 0x44])
    assert bus.read_i2c_block_data(ADDRESS, CTRL1 | 0x80, 2) == [0xD7, 0x44]
    assert bus.read_word_data(ADDRESS, CTRL1 | 0x80) == 0x44D7
    bus.write_word_data(ADDRESS, CTRL1 | 0x80, 0x4007)
    assert (get(bus, CTRL1), get(bus, CTRL2)) == (0x07, 0x40)
    bus.write_byte(ADDRESS, CTRL2)
    assert bus.read_byte(ADDRESS) == 0x40
    bus.write_block_data(ADDRESS, CTRL1 | 0x80, [0x66])  # the count goes over the bus as a byte
    assert (get(bus, CTRL1), get(bus, CTRL2)) == (0x01, 0x66)
    assert bus.process_call(ADDRESS, 0x16 | 0x80, 0x2211) == 0x0000
    assert bus.read_word_data(ADDRESS, 0x16 | 0x80) == 0x2211


@pytest.mark.parametrize("request_of", ["read_block_data", "block_process_call"])
def test_requests_that_plain_i2c_does_not_have(bus: smbus2.SMBus, request_of: str) -> None:
    arguments: tuple[Any, ...] = (ADDRESS, 0x20) if request_of == "read_block_data" else (ADDRESS, 0x20, [1])
    with pytest.raises(OSError) as caught:
        getattr(bus, request_of)(*arguments)
    assert caught.value.errno == errno.EOPNOTSUPP
    assert not bus.funcs & smbus2.I2cFunc.SMBUS_READ_BLOCK_DATA
    assert bus.funcs & smbus2.I2cFunc.I2C


@pytest.mark.parametrize("address", [0x00, 0x1C, 0x53])
def test_nobody_acknowledges_at_another_address(bus: smbus2.SMBus, address: int) -> None:
    for request in (
        lambda: bus.read_byte_data(address, 0x0F),
        lambda: bus.write_quick(address),
        lambda: bus.i2c_rdwr(smbus2.i2c_msg.read(address, 1)),
    ):
        with pytest.raises(OSError) as caught:
            request()
        assert caught.value.errno == errno.EREMOTEIO


def test_requests_that_the_kernel_refuses(bus: smbus2.SMBus) -> None:
    many = [smbus2.i2c_msg.read(ADDRESS, 1)] * 43
    for request, number in (
        (bus.i2c_rdwr, errno.EINVAL),
        (lambda: bus.i2c_rdwr(*many), errno.EINVAL),
        (lambda: bus.i2c_rdwr(smbus2.i2c_msg.read(ADDRESS, 8193)), errno.EINVAL),
        (lambda: bus.read_byte_data(0x80, 0x0F), errno.EINVAL),
        (lambda: bus.read_i2c_block_data(ADDRESS, 0x0F, 0), errno.EINVAL),
    ):
        with pytest.raises(OSError) as caught:
            request()
        assert caught.value.errno == number
    with pytest.raises(OSError, match="SMBUS_PEC"):
        bus.pec = 1


@pytest.mark.parametrize(("request_number", "number"), [(0x0704, errno.ENOTTY), (0x9999, errno.ENOTTY)])
def test_unknown_requests(registers: SensedRegisters, request_number: int, number: int) -> None:
    adapter = I2cAdapter(ADDRESS, Lis3lv02dqChip(NAME))
    with pytest.raises(OSError) as caught:
        adapter.ioctl(request_number, 0)
    assert caught.value.errno == number
    adapter.close()
    adapter.close()


def test_failures(bus: smbus2.SMBus, registers: SensedRegisters) -> None:
    put(bus, CTRL1, 0xF7)
    registers.publish((G, G, G))
    registers.inject(Failure.WRONG_IDENTITY)
    assert get(bus, 0x0F) == 0xC5
    registers.inject(Failure.GARBAGE)
    first, second = burst(bus, STATUS | 0x80, 7), burst(bus, OUT | 0x80, 6)
    assert first[0] == 0x0F
    assert len({first[1:], second, b"\x00\x04" * 3}) == 3
    registers.inject(Failure.NAK)
    with pytest.raises(OSError) as caught:
        get(bus, 0x0F)
    assert caught.value.errno == errno.EREMOTEIO
    registers.inject(Failure.STUCK)
    registers.publish((0.0, 0.0, 0.0))
    assert burst(bus, STATUS | 0x80, 7) == b"\x00" + b"\x00\x04" * 3
    registers.inject(Failure.NONE)
    registers.publish((0.0, 0.0, 0.0))
    assert burst(bus, STATUS | 0x80, 7) == b"\x0f" + bytes(6)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=20), st.integers(0, 200)), max_size=12))
def test_no_bytes_make_the_chip_raise(transfers: list[tuple[bytes, int]]) -> None:
    registers = SensedRegisters(NAME, LIS3LV02DQ_PART)
    chip = Lis3lv02dqChip(NAME)
    try:
        for data, length in transfers:
            chip.write(data)
            registers.publish((30.0, -30.0, 0.1))
            assert len(chip.read(length)) == length
        chip.write(b"\x0f")
        assert chip.read(1) == b"\x3a"
    finally:
        chip.close()
        registers.close()
