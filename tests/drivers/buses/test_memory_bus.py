"""The emulated chip's registers and the emulated kernel's requests, seen from smbus2."""

import errno

import pytest
import smbus2


@pytest.mark.parametrize("address", [0x00, 0x1C, 0x53])
def test_nobody_acknowledges_at_another_address(chip_bus: smbus2.SMBus, address: int) -> None:
    for request in (
        lambda: chip_bus.read_byte_data(address, 0x0F),
        lambda: chip_bus.write_quick(address),
        lambda: chip_bus.i2c_rdwr(smbus2.i2c_msg.read(address, 1)),
    ):
        with pytest.raises(OSError) as caught:
            request()
        assert caught.value.errno == errno.EREMOTEIO
