"""An emulated CiA 402 drive: CAN messages and times in, CAN messages out. Pure.

It implements NMT start and stop, expedited SDOs on the objects below, RPDO1, SYNC, the master's heartbeat, the state
machine with fault, fault reset and quick stop, and both dead-man timers: the master's heartbeat (1016) and RPDO1's
event timer (1400:05). Either causes a quick stop. Injected failures: `silent`, fail(), `refused` objects, `garbage`.
"""

import struct

from stillarm.drivers.drives.cia402_states import DriveState

_WORDS = {
    DriveState.DISABLED: 0x240,
    DriveState.READY: 0x221,
    DriveState.SWITCHED_ON: 0x223,
    DriveState.ENABLED: 0x227,
    DriveState.QUICK_STOP: 0x207,
    DriveState.FAULT: 0x208,
}
_ABORT_NO_OBJECT, _ABORT_LENGTH = 0x06020000, 0x06070010
_OPERATIONAL, _PRE_OPERATIONAL = 5, 127
_CAN = tuple[int, bytes]
_SIZES = {
    (0x1016, 1): 4,
    (0x6007, 0): 2,
    (0x6060, 0): 1,
    (0x603F, 0): 2,
    (0x1000, 0): 4,
    (0x1018, 1): 4,
    (0x1018, 2): 4,
    (0x6040, 0): 2,
    (0x6041, 0): 2,
    (0x6064, 0): 4,
    (0x606C, 0): 4,
    (0x60FF, 0): 4,
    (0x1400, 5): 2,
    **{(index, 1): 4 for index in (0x1400, 0x1800, 0x1801)},
    **{(index, 2): 1 for index in (0x1400, 0x1800, 0x1801)},
    **{(index, 0): 1 for index in (0x1600, 0x1A00, 0x1A01)},
    **{(index, sub): 4 for index in (0x1600, 0x1A00, 0x1A01) for sub in (1, 2)},
}


class Cia402Node:
    """One drive, its motor's position and velocity in the units of 6064 and 606C."""

    def __init__(self, node: int) -> None:
        """Pre-operational, as after power-up."""
        self.node = node
        self._objects = dict.fromkeys(_SIZES, 0)
        self._objects[0x1000, 0] = 0x0002_0192
        self._objects[0x1018, 1], self._objects[0x1018, 2] = 0x5A, 0x402
        self._nmt = _PRE_OPERATIONAL
        self._state = DriveState.DISABLED
        self._commanded_s = self._master_s = 0.0
        self._now_s = 0.0
        self.position_units = 0
        self.velocity_units_s = 0
        self.commands = 0
        self.silent = self.garbage = False
        self.refused: set[tuple[int, int]] = set()

    @property
    def state(self) -> DriveState:
        """The state of its state machine."""
        return self._state

    def receive(self, identifier: int, data: bytes, now_s: float) -> list[_CAN]:
        """Receive a message that arrived at `now_s`. Returns the answers."""
        self._now_s = now_s
        self._watch()
        answers: list[_CAN] = []
        if identifier == 0x600 + self.node and len(data) == 8:
            answers.append((0x580 + self.node, self._sdo(data)))
        elif identifier == 0x000 and len(data) == 2 and data[1] in (0, self.node):
            self._nmt = {1: _OPERATIONAL, 2: 4, 128: _PRE_OPERATIONAL}.get(data[0], self._nmt)
            self._commanded_s = self._master_s = now_s
        elif identifier == 0x200 + self.node and len(data) == 6 and self._nmt == _OPERATIONAL:
            control, target = struct.unpack("<Hi", data)
            self._commanded_s = now_s
            self.commands += 1
            self._objects[0x60FF, 0] = target
            self._obey(control)
        elif identifier == 0x080 and self._nmt == _OPERATIONAL:
            answers += self._reports()
        elif identifier == 0x700 + (self._objects[0x1016, 1] >> 16) and identifier != 0x700:
            self._master_s = now_s
        return [] if self.silent else answers

    def velocity_command(self, now_s: float) -> int:
        """The motor's velocity command at `now_s`, in the units of 60FF; zero unless enabled."""
        self._now_s = now_s
        self._watch()
        return self._objects[0x60FF, 0] if self._state == DriveState.ENABLED else 0

    def fail(self, code: int) -> None:
        """Enter a fault: the drive stops until it is reset."""
        self._state = DriveState.FAULT
        self._objects[0x603F, 0] = code

    def _watch(self) -> None:
        if self._state != DriveState.ENABLED:
            return
        heartbeat_s = (self._objects[0x1016, 1] & 0xFFFF) / 1000.0
        timer_s = self._objects[0x1400, 5] / 1000.0
        late = (heartbeat_s and self._now_s - self._master_s > heartbeat_s) or (
            timer_s and self._now_s - self._commanded_s > timer_s
        )
        if late:
            self._state = DriveState.QUICK_STOP if self._objects[0x6007, 0] == 3 else DriveState.FAULT
            self._objects[0x603F, 0] = 0x8130  # life guard error

    def _obey(self, control: int) -> None:
        """The transitions of CiA 402 that a control word requests."""
        state = self._state
        if state == DriveState.FAULT:
            if control & 0x80 and not self._objects[0x6040, 0] & 0x80:
                self._state = DriveState.DISABLED
        elif control & 0x02 == 0:
            self._state = DriveState.DISABLED
        elif control & 0x04 == 0:
            self._state = DriveState.QUICK_STOP if state == DriveState.ENABLED else DriveState.DISABLED
        elif control & 0x0F == 0x06 and state != DriveState.QUICK_STOP:
            self._state = DriveState.READY
        elif control & 0x0F == 0x07 and state in (DriveState.READY, DriveState.ENABLED):
            self._state = DriveState.SWITCHED_ON
        elif control & 0x0F == 0x0F and state in (DriveState.SWITCHED_ON, DriveState.READY):
            self._state = DriveState.ENABLED
        self._objects[0x6040, 0] = control

    def _reports(self) -> list[_CAN]:
        reports = [
            (0x180 + self.node, struct.pack("<Hi", _WORDS[self._state], self.position_units)),
            (0x280 + self.node, struct.pack("<i", self.velocity_units_s)),
        ]
        return [(identifier, data[:3]) for identifier, data in reports] if self.garbage else reports

    def _sdo(self, data: bytes) -> bytes:
        """An expedited transfer (CiA 301, 7.2.4): 0x2F, 2B, 23 = write 1, 2, 4 bytes; 0x40 = read."""
        command, index, sub = struct.unpack_from("<BHB", data)
        key = (index, sub)
        size = _SIZES.get(key)
        if size is None or key in self.refused:
            return struct.pack("<BHBI", 0x80, index, sub, _ABORT_NO_OBJECT)
        if command == 0x40:
            value = self._value(key)
            return struct.pack("<BHB", 0x43 | (4 - size) << 2, index, sub) + value.to_bytes(4, "little")
        if command & 0xE3 != 0x23 or 4 - (command >> 2 & 3) != size:
            return struct.pack("<BHBI", 0x80, index, sub, _ABORT_LENGTH)
        self._objects[key] = int.from_bytes(data[4 : 4 + size], "little")
        return struct.pack("<BHBI", 0x60, index, sub, 0)

    def _value(self, key: tuple[int, int]) -> int:
        own = {
            (0x6041, 0): _WORDS[self._state],
            (0x6064, 0): self.position_units & 0xFFFF_FFFF,
            (0x606C, 0): self.velocity_units_s & 0xFFFF_FFFF,
        }
        return own.get(key, self._objects[key])
