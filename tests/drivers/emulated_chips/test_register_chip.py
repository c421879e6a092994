"""The emulated chips by bytes, as their data sheets describe them: power-up, reset, banks, what frees data-ready."""

import os
from collections.abc import Iterator

import pytest
import smbus2
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.drivers.buses.i2c import open_bus
from stillarm.drivers.buses.parts import SENSED_PARTS, open_part
from stillarm.drivers.emulated_chips.shared_registers import SensedRegisters

NAME = f"test-register-chip-{os.getpid()}"
G = 9.80665
PARTS = sorted(set(SENSED_PARTS) - {"lis3lv02dq"})


class Chip:
    """A bus with one part on it."""

    def __init__(self, part: str, address: int) -> None:
        self.registers = SensedRegisters(NAME, SENSED_PARTS[part])
        self.address = address
        self.bus = open_bus(f"memory:{NAME}")

    def put(self, register: int, *values: int) -> None:
        for value in values:
            self.bus.write_byte_data(self.address, register, value)

    def get(self, register: int, length: int = 1) -> bytes:
        answer = smbus2.i2c_msg.read(self.address, length)
        self.bus.i2c_rdwr(smbus2.i2c_msg.write(self.address, [register]), answer)
        return bytes(answer)

    def feel(self, x: float, y: float = 0.0, z: float = 0.0) -> None:
        self.registers.publish((x, y, z))


@pytest.fixture
def chip(part: str, address: int) -> Iterator[Chip]:
    made = Chip(part, address)
    yield made
    made.bus.close()
    made.registers.close()


@pytest.mark.parametrize(("part", "address"), [("lis3dh", 0x18)])
def test_lis3dh(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x0F) == b"\x33"
    chip.feel(G)
    assert chip.get(0xA7, 7) == bytes(7)  # powered down
    chip.put(0x20, 0x97)
    chip.put(0x23, 0x88)
    chip.feel(G)
    assert chip.get(0xA7, 7) == bytes.fromhex("0F 803E 0000 0000")
    assert chip.get(0xA7, 1) == b"\x00"  # read
    chip.feel(G)
    chip.feel(G)
    assert chip.get(0x27) == b"\xff"  # overrun
    chip.put(0x23, 0x80)  # normal mode: 10 bit
    chip.feel(G)
    assert chip.get(0xA8, 2) == bytes.fromhex("803E")
    chip.put(0x23, 0xB8)  # 16 g: 12 mg a count
    chip.feel(G)
    assert chip.get(0xA8, 2) == (round(1000 / 12) << 4).to_bytes(2, "little")


@pytest.mark.parametrize(("part", "address"), [("adxl345", 0x53)])
def test_adxl345(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x00) == b"\xe5"
    assert chip.get(0x2C) == b"\x0a"  # 100 Hz
    chip.feel(G)
    assert chip.get(0x30) == b"\x00"  # standby
    chip.put(0x2D, 0x08)
    chip.put(0x2C, 0x0D)
    chip.put(0x31, 0x0B)  # full resolution, 16 g
    for _ in range(2):
        chip.feel(10 * G, -1 * G)
    assert chip.get(0x30, 8) == bytes.fromhex("80 0B 000A 00FF 0000")
    assert chip.get(0x30) == b"\x00"
    chip.put(0x31, 0x01)  # 10 bit at 4 g
    for _ in range(2):
        chip.feel(G)
    assert chip.get(0x32, 2) == bytes.fromhex("8000")


@pytest.mark.parametrize(("part", "address"), [("adxl355", 0x1D)])
def test_adxl355(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x00, 4) == bytes.fromhex("AD1DED01")
    assert chip.get(0x2D) == b"\x01"  # standby
    chip.put(0x2C, 0x82)
    chip.put(0x2D, 0x00)
    chip.put(0x28, 0x02)
    chip.feel(G, -G)
    assert chip.get(0x04, 13) == bytes.fromhex("01 03 0000 1F4000 E0C000 000000")
    assert chip.get(0x04)[0] & 0x01 == 0
    assert chip.get(0x11, 9) == bytes.fromhex("1F4001 E0C000 000000")  # the FIFO, with its marker on x
    assert chip.get(0x05) == b"\x00"
    chip.put(0x00, 0x12)
    assert chip.get(0x00) == b"\xad"
    chip.put(0x2F, 0x52)  # reset
    assert (chip.get(0x2C), chip.get(0x2D), chip.get(0x28)) == (b"\x81", b"\x01", b"\x00")


@pytest.mark.parametrize(("part", "address"), [("mpu6050", 0x68)])
def test_mpu6050(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x75) == b"\x68"
    assert chip.get(0x6B) == b"\x40"  # asleep
    chip.feel(G)
    chip.put(0x6B, 0x01)
    chip.put(0x1A, 0x01)
    chip.feel(G, -G / 2)
    assert chip.get(0x3A, 7) == bytes.fromhex("00 4000 E000 0000")  # not told unless it is enabled
    chip.put(0x38, 0x01)
    chip.feel(G)
    assert chip.get(0x3B, 6)[:2] == b"\x40\x00"
    assert chip.get(0x3A) == b"\x01"  # freed by its own read alone
    assert chip.get(0x3A) == b"\x00"
    chip.put(0x1C, 0x18)
    chip.feel(G)
    assert chip.get(0x3B, 2) == b"\x08\x00"


@pytest.mark.parametrize(("part", "address"), [("icm20948", 0x68)])
def test_icm20948(part: str, address: int, chip: Chip) -> None:
    assert chip.get(0x00) == b"\xea"
    chip.put(0x06, 0x01)
    chip.put(0x11, 0x01)
    chip.put(0x7F, 0x20)
    assert chip.get(0x00) == b"\x00"  # another bank
    chip.put(0x14, 0x03)  # 4 g
    chip.put(0x11, 0x00)
    chip.put(0x7F, 0x00)
    assert chip.get(0x11) == b"\x01"
    chip.feel(G, -G)
    assert chip.get(0x1A) == b"\x01"
    assert chip.get(0x2D, 6) == bytes.fromhex("2000 E000 0000")
    assert chip.get(0x1A) == b"\x00"


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=20), st.integers(0, 200)), max_size=12))
def test_no_bytes_make_a_chip_raise(part: str, transfers: list[tuple[bytes, int]]) -> None:
    registers = SensedRegisters(NAME, SENSED_PARTS[part])
    adapter = open_part(NAME, 0.0)
    device = adapter._device
    try:
        for data, length in transfers:
            device.write(data)
            registers.publish((30.0, -30.0, 0.1))
            assert len(device.read(length)) == length
    finally:
        adapter.close()
        registers.close()
