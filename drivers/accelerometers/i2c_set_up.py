"""Sets up an I2C accelerometer, one transfer at a time: all at the start, and one step a cycle after a loss."""

import smbus2

from stillarm.drivers.accelerometers.register_tables.register_table import (
    FilterSetting,
    FullScale,
    RegisterTable,
    Write,
)


class WrongIdentity(Exception):
    """Another device answered. found: the bytes that it returned."""

    def __init__(self, found: bytes) -> None:
        super().__init__(found.hex())
        self.found = found


class SetUp:
    """Makes the identity visible and checks it, writes every register with the chosen range and filter, and waits."""

    def __init__(
        self, table: RegisterTable, address: int, full_scale: FullScale, chosen: FilterSetting
    ) -> None:
        """Accesses nothing yet."""
        self._table = table
        self._address = address
        writes = [_with_bits(write, full_scale, chosen) for write in table.set_up]
        self._steps: tuple[Write | None, ...] = (*table.before_identity, None, *writes)
        self._next = 0
        self._not_before_s = 0.0

    def restart(self, now_s: float, wait_s: float = 0.0) -> None:
        """Start again after `wait_s`."""
        self._next = 0
        self._not_before_s = now_s + wait_s

    def advance(self, bus: smbus2.SMBus, now_s: float) -> bool:
        """Take the next step if it is due. Returns True when all is done. Raises OSError and WrongIdentity."""
        if now_s < self._not_before_s:
            return False
        if self._next == len(self._steps):
            return True
        step = self._steps[self._next]
        if step is None:
            self._check_identity(bus)
        else:
            bus.write_byte_data(self._address, step.register, step.value)
        self._next += 1
        last = self._next == len(self._steps)
        self._not_before_s = now_s + (self._table.start_up_s if last else step.wait_s if step else 0.0)
        return False

    @property
    def waits_s(self) -> float:
        """The time until which the next step waits."""
        return self._not_before_s

    def _check_identity(self, bus: smbus2.SMBus) -> None:
        table = self._table
        found = read_registers(
            bus, self._address, table.identity_register | _increment(table), len(table.identity)
        )
        if found != table.identity:
            raise WrongIdentity(found)


def read_registers(bus: smbus2.SMBus, address: int, register: int, length: int) -> bytes:
    """Read `length` bytes, starting at a register, in one transfer. Raises OSError."""
    answer = smbus2.i2c_msg.read(address, length)
    bus.i2c_rdwr(smbus2.i2c_msg.write(address, [register]), answer)
    return bytes(answer)


def _with_bits(write: Write, full_scale: FullScale, chosen: FilterSetting) -> Write:
    bits = full_scale.bits.get(write.register, 0) | chosen.bits.get(write.register, 0)
    return Write(write.register, write.value | bits, write.wait_s)


def _increment(table: RegisterTable) -> int:
    return table.auto_increment if len(table.identity) > 1 else 0
