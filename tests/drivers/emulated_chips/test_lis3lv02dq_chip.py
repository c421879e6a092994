"""The chip's own behaviour, as its data sheet has it."""

import errno

import pytest
import smbus2
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.drivers.emulated_chips.lis3lv02dq_chip import Lis3lv02dqChip
from stillarm.drivers.emulated_chips.lis3lv02dq_registers import LIS3LV02DQ_PART
from stillarm.drivers.emulated_chips.shared_registers import STANDARD_GRAVITY_M_S2, Failure, SensedRegisters
from tests.fixtures.lis3lv02dq import ADDRESS, CTRL1, CTRL2, NAME, OUT, STATUS, get

G = STANDARD_GRAVITY_M_S2


def burst(chip_bus: smbus2.SMBus, first: int, length: int) -> bytes:
    write, read = smbus2.i2c_msg.write(ADDRESS, [first]), smbus2.i2c_msg.read(ADDRESS, length)
    chip_bus.i2c_rdwr(write, read)
    return bytes(read)


def put(chip_bus: smbus2.SMBus, register: int, value: int) -> None:
    chip_bus.write_byte_data(ADDRESS, register, value)


def test_identity_and_state_after_power_up(chip_bus: smbus2.SMBus) -> None:
    assert get(chip_bus, 0x0F) == 0x3A
    assert (get(chip_bus, CTRL1), get(chip_bus, CTRL2), get(chip_bus, STATUS)) == (0x07, 0x00, 0x00)


def test_powered_down_there_is_no_data(chip_bus: smbus2.SMBus, chip_registers: SensedRegisters) -> None:
    chip_registers.publish((G, G, G))
    assert burst(chip_bus, STATUS | 0x80, 7) == bytes(7)
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((G, G, G))
    assert burst(chip_bus, STATUS | 0x80, 7) == b"\x0f" + b"\x00\x04" * 3
    put(chip_bus, CTRL1, 0x07)
    chip_registers.publish((0.0, 0.0, 0.0))
    assert burst(chip_bus, STATUS | 0x80, 7) == b"\x00" + b"\x00\x04" * 3


def test_data_ready_and_overrun(chip_bus: smbus2.SMBus, chip_registers: SensedRegisters) -> None:
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((0.0, 0.0, 0.0))
    assert get(chip_bus, STATUS) == 0x0F
    assert get(chip_bus, STATUS) == 0x0F  # reading the status frees nothing
    chip_registers.publish((0.0, 0.0, 0.0))
    assert get(chip_bus, STATUS) == 0xFF
    burst(chip_bus, (OUT + 2) | 0x80, 2)  # y alone
    assert get(chip_bus, STATUS) == 0x01 | 0x04 | 0x10 | 0x40
    burst(chip_bus, OUT | 0x80, 6)
    assert get(chip_bus, STATUS) == 0x00


def test_a_disabled_axis_gives_no_data(chip_bus: smbus2.SMBus, chip_registers: SensedRegisters) -> None:
    put(chip_bus, CTRL1, 0xF0 | 0x02)
    chip_registers.publish((G, G, G))
    assert burst(chip_bus, STATUS | 0x80, 7) == b"\x0a" + b"\x00\x00" + b"\x00\x04" + b"\x00\x00"


def test_auto_increment_only_where_it_is_asked_for(
    chip_bus: smbus2.SMBus, chip_registers: SensedRegisters
) -> None:
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((G, 0.5 * G, -G))
    assert burst(chip_bus, OUT | 0x80, 6) == b"\x00\x04\x00\x02\x00\xfc"
    assert burst(chip_bus, OUT + 1, 3) == b"\x04\x04\x04"
    chip_bus.i2c_rdwr(smbus2.i2c_msg.write(ADDRESS, [CTRL1 | 0x80, 0xD7, 0x44]))
    assert (get(chip_bus, CTRL1), get(chip_bus, CTRL2)) == (0xD7, 0x44)
    chip_bus.i2c_rdwr(smbus2.i2c_msg.write(ADDRESS, [CTRL1, 0xC7, 0xF7]))
    assert (get(chip_bus, CTRL1), get(chip_bus, CTRL2)) == (0xF7, 0x44)


def test_the_pointer_stays_between_messages(chip_bus: smbus2.SMBus) -> None:
    put(chip_bus, CTRL2, 0x44)
    chip_bus.i2c_rdwr(smbus2.i2c_msg.write(ADDRESS, [CTRL1 | 0x80]))
    first, second = smbus2.i2c_msg.read(ADDRESS, 1), smbus2.i2c_msg.read(ADDRESS, 1)
    chip_bus.i2c_rdwr(first, second)
    assert (bytes(first), bytes(second)) == (b"\x07", b"\x44")
    assert burst(chip_bus, 0x7F | 0x80, 17)[16] == 0x3A  # past the last register it goes on at the first


def test_identity_status_and_samples_cannot_be_written(
    chip_bus: smbus2.SMBus, chip_registers: SensedRegisters
) -> None:
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((G, G, G))
    for register in (0x0F, STATUS, *range(OUT, OUT + 6)):
        put(chip_bus, register, 0x55)
    assert get(chip_bus, 0x0F) == 0x3A
    assert burst(chip_bus, STATUS | 0x80, 7) == b"\x0f" + b"\x00\x04" * 3


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
    chip_bus: smbus2.SMBus, chip_registers: SensedRegisters, control2: int, expected: bytes
) -> None:
    put(chip_bus, CTRL2, control2)
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((0.5 * G, 0.0, 0.0))
    assert burst(chip_bus, OUT | 0x80, 2) == expected


@pytest.mark.parametrize("block_update", [True, False])
def test_block_update_keeps_an_axis_until_both_bytes_are_read(
    chip_bus: smbus2.SMBus, chip_registers: SensedRegisters, block_update: bool
) -> None:
    put(chip_bus, CTRL2, 0x40 if block_update else 0x00)
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((255 * G / 1024, 0.0, 0.0))
    low = get(chip_bus, OUT)
    chip_registers.publish((256 * G / 1024, 256 * G / 1024, 0.0))
    high = get(chip_bus, OUT + 1)
    assert high << 8 | low == (0x00FF if block_update else 0x01FF)
    assert burst(chip_bus, (OUT + 2) | 0x80, 2) == b"\x00\x01"
    assert burst(chip_bus, STATUS | 0x80, 3)[1:] == b"\x00\x01"


@pytest.mark.parametrize(("rate_bits", "taken"), [(0x00, 40), (0x10, 160), (0x20, 640), (0x30, 1000)])
def test_output_rate_of_samples_fed_at_1_khz(
    chip_bus: smbus2.SMBus, chip_registers: SensedRegisters, rate_bits: int, taken: int
) -> None:
    put(chip_bus, CTRL1, 0xC7 | rate_bits)
    fresh = 0
    for _ in range(1000):
        chip_registers.publish((0.0, 0.0, 0.0))
        fresh += burst(chip_bus, STATUS | 0x80, 7)[0] & 0x08 == 0x08
    assert fresh == taken


def test_failures(chip_bus: smbus2.SMBus, chip_registers: SensedRegisters) -> None:
    put(chip_bus, CTRL1, 0xF7)
    chip_registers.publish((G, G, G))
    chip_registers.inject(Failure.WRONG_IDENTITY)
    assert get(chip_bus, 0x0F) == 0xC5
    chip_registers.inject(Failure.GARBAGE)
    first, second = burst(chip_bus, STATUS | 0x80, 7), burst(chip_bus, OUT | 0x80, 6)
    assert first[0] == 0x0F
    assert len({first[1:], second, b"\x00\x04" * 3}) == 3
    chip_registers.inject(Failure.NAK)
    with pytest.raises(OSError) as caught:
        get(chip_bus, 0x0F)
    assert caught.value.errno == errno.EREMOTEIO
    chip_registers.inject(Failure.STUCK)
    chip_registers.publish((0.0, 0.0, 0.0))
    assert burst(chip_bus, STATUS | 0x80, 7) == b"\x00" + b"\x00\x04" * 3
    chip_registers.inject(Failure.NONE)
    chip_registers.publish((0.0, 0.0, 0.0))
    assert burst(chip_bus, STATUS | 0x80, 7) == b"\x0f" + bytes(6)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=20), st.integers(0, 200)), max_size=12))
def test_no_bytes_make_the_chip_raise(transfers: list[tuple[bytes, int]]) -> None:
    chip_registers = SensedRegisters(NAME, LIS3LV02DQ_PART)
    chip = Lis3lv02dqChip(NAME)
    try:
        for data, length in transfers:
            chip.write(data)
            chip_registers.publish((30.0, -30.0, 0.1))
            assert len(chip.read(length)) == length
        chip.write(b"\x0f")
        assert chip.read(1) == b"\x3a"
    finally:
        chip.close()
        chip_registers.close()
