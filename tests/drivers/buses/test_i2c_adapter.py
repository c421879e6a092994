"""Requests of /dev/i2c-N, answered as the kernel would."""

import errno
from typing import Any

import pytest
import smbus2

from stillarm.drivers.buses.i2c_adapter import I2cAdapter
from stillarm.drivers.emulated_chips.lis3lv02dq_chip import Lis3lv02dqChip
from stillarm.drivers.emulated_chips.shared_registers import SensedRegisters
from tests.fixtures.lis3lv02dq import ADDRESS, CTRL1, CTRL2, NAME, get


def test_requests_of_smbus(chip_bus: smbus2.SMBus) -> None:
    chip_bus.write_quick(ADDRESS)
    chip_bus.write_i2c_block_data(ADDRESS, CTRL1 | 0x80, [0xD7, 0x44])
    assert chip_bus.read_i2c_block_data(ADDRESS, CTRL1 | 0x80, 2) == [0xD7, 0x44]
    assert chip_bus.read_word_data(ADDRESS, CTRL1 | 0x80) == 0x44D7
    chip_bus.write_word_data(ADDRESS, CTRL1 | 0x80, 0x4007)
    assert (get(chip_bus, CTRL1), get(chip_bus, CTRL2)) == (0x07, 0x40)
    chip_bus.write_byte(ADDRESS, CTRL2)
    assert chip_bus.read_byte(ADDRESS) == 0x40
    chip_bus.write_block_data(ADDRESS, CTRL1 | 0x80, [0x66])  # the count goes over the bus as a byte
    assert (get(chip_bus, CTRL1), get(chip_bus, CTRL2)) == (0x01, 0x66)
    assert chip_bus.process_call(ADDRESS, 0x16 | 0x80, 0x2211) == 0x0000
    assert chip_bus.read_word_data(ADDRESS, 0x16 | 0x80) == 0x2211


@pytest.mark.parametrize("request_of", ["read_block_data", "block_process_call"])
def test_requests_that_plain_i2c_does_not_have(chip_bus: smbus2.SMBus, request_of: str) -> None:
    arguments: tuple[Any, ...] = (ADDRESS, 0x20) if request_of == "read_block_data" else (ADDRESS, 0x20, [1])
    with pytest.raises(OSError) as caught:
        getattr(chip_bus, request_of)(*arguments)
    assert caught.value.errno == errno.EOPNOTSUPP
    assert not chip_bus.funcs & smbus2.I2cFunc.SMBUS_READ_BLOCK_DATA
    assert chip_bus.funcs & smbus2.I2cFunc.I2C


def test_requests_that_the_kernel_refuses(chip_bus: smbus2.SMBus) -> None:
    many = [smbus2.i2c_msg.read(ADDRESS, 1)] * 43
    for request, number in (
        (chip_bus.i2c_rdwr, errno.EINVAL),
        (lambda: chip_bus.i2c_rdwr(*many), errno.EINVAL),
        (lambda: chip_bus.i2c_rdwr(smbus2.i2c_msg.read(ADDRESS, 8193)), errno.EINVAL),
        (lambda: chip_bus.read_byte_data(0x80, 0x0F), errno.EINVAL),
        (lambda: chip_bus.read_i2c_block_data(ADDRESS, 0x0F, 0), errno.EINVAL),
    ):
        with pytest.raises(OSError) as caught:
            request()
        assert caught.value.errno == number
    with pytest.raises(OSError, match="SMBUS_PEC"):
        chip_bus.pec = 1


@pytest.mark.parametrize(("request_number", "number"), [(0x0704, errno.ENOTTY), (0x9999, errno.ENOTTY)])
def test_unknown_requests(chip_registers: SensedRegisters, request_number: int, number: int) -> None:
    adapter = I2cAdapter(ADDRESS, Lis3lv02dqChip(NAME))
    with pytest.raises(OSError) as caught:
        adapter.ioctl(request_number, 0)
    assert caught.value.errno == number
    adapter.close()
    adapter.close()
