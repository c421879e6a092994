"""A CiA 402 drive on a CAN bus: set up once by SDO, then driven with raw messages only.

Each command is RPDO1 (control word, target velocity) and a SYNC, which the drive answers with status word, position and
velocity. A heartbeat follows every 20 ms. Each status word determines the next control word.
"""

import struct
import time
from collections.abc import Callable
from math import inf, isfinite, nan, pi
from typing import Any

from stillarm.common.files.configuration import DriveDevice
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.cia402_set_up import MASTER, can_package, fault_code, look, open_can, set_up
from stillarm.drivers.drives.cia402_states import (
    ENABLE,
    QUICK_STOP,
    DriveState,
    drive_state,
    next_control_word,
)
from stillarm.drivers.drives.drive import DriveProbe, JointState

_COMMAND = struct.Struct("<Hi")
_STATUS_POSITION = struct.Struct("<Hi")
_VELOCITY = struct.Struct("<i")
_INT32 = 2**31 - 1
_HEARTBEAT_S = 0.02
_OPERATIONAL = b"\x05"
_MAX_MESSAGES = 32  # per read, from any node on the bus
_ENABLE_S = 2.0
_POLL_S = 0.002
_RETRY_S = 0.5


class Cia402Drive:
    """Commands a joint's velocity and receives its state; implements stillarm.drivers.drives.drive.Drive.

    A drive that leaves 'operation enabled' (dead-man timer, fault) is enabled again, but only while the command is
    zero. A drive that lost its settings with its power does not answer SYNC; it stays absent until the program
    restarts.
    """

    def __init__(
        self,
        config: DriveDevice,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Opens nothing."""
        self._config = config.cia402
        turns_per_rad = config.gear_ratio / (2.0 * pi)
        self._units_s_per_rad = turns_per_rad * self._config.velocity_units_s_per_turn
        self._units_per_rad = turns_per_rad * self._config.position_units_per_turn
        self._clock, self._sleep = clock, sleep
        self._bus: Any = None
        self._message: Any = None
        self._can_errors: tuple[type[Exception], ...] = (OSError,)
        self._control = 0
        self._position = self._velocity = nan
        self._good_s = self._heartbeat_s = self._retry_s = -inf
        self._running = False
        self.drive_state = DriveState.UNKNOWN
        self.identity = ""
        self.refused = 0
        """Commands that were not finite; zero was sent instead."""
        self.send_failures = 0

    def start(self) -> None:
        """Set the drive up and enable it at zero velocity. Raises UserError with a remedy."""
        self.close()
        self.identity = set_up(self._config)
        self._open()
        self._running = True
        until = self._clock() + _ENABLE_S
        while self.drive_state != DriveState.ENABLED and self._clock() < until:
            self.command(0.0)
            self._sleep(_POLL_S)
            self.state()
        if self.drive_state != DriveState.ENABLED:
            state = self.drive_state
            self.close()
            code = f", fault code {fault_code(self._config):#06x}" if state == DriveState.FAULT else ""
            raise UserError(
                f"drive.cia402.node = {self._config.node}: the drive stays in {state.value!r}{code}; look "
                "it up in its manual; check its power stage, enable input and brake"
            )

    def command(self, velocity_rad_s: float) -> None:
        """Send the joint velocity command. A command that is not finite is counted and sent as zero."""
        if not self._running:
            raise RuntimeError("command() before start()")
        if not isfinite(velocity_rad_s):
            self.refused += 1
            velocity_rad_s = 0.0
        now = self._clock()
        if self._bus is None:
            self._reopen(now)
            return
        enabled = self.drive_state == DriveState.ENABLED
        units = round(velocity_rad_s * self._units_s_per_rad) if enabled else 0
        if enabled:
            self._control = ENABLE
        elif velocity_rad_s == 0.0:
            self._control = next_control_word(self.drive_state, self._control)
        self._send_command(self._control, min(max(units, -_INT32), _INT32))
        self._send(0x80, b"")
        if now - self._heartbeat_s >= _HEARTBEAT_S:
            self._heartbeat_s = now
            self._send(0x700 + MASTER, _OPERATIONAL)

    def state(self) -> JointState:
        """The newest report; never blocks. Before the first one: NaN, NaN and an infinite age."""
        if not self._running:
            raise RuntimeError("state() before start()")
        if self._bus is not None:
            try:
                for _ in range(_MAX_MESSAGES):
                    message = self._bus.recv(0)
                    if message is None:
                        break
                    self._take(message.arbitration_id - self._config.node, bytes(message.data))
            except self._can_errors:
                self._lose()
        return JointState(self._position, self._velocity, self._clock() - self._good_s)

    def probe(self, span_s: float) -> DriveProbe:
        """Read identity, state and position by SDO, without commanding or enabling. Raises UserError."""
        until, reports, name, status, position = self._clock() + span_s, 0, "", 0, 0
        while not reports or self._clock() < until:
            name, status, position = look(self._config)
            reports += 1
        notes = []
        if drive_state(status) == DriveState.FAULT:
            notes.append(
                f"the drive is in a fault ({fault_code(self._config):#06x}); look the code up in its manual; "
                "a start resets it"
            )
        return DriveProbe(name, reports, span_s, position / self._units_per_rad, tuple(notes))

    def close(self) -> None:
        """Command zero, quick stop, release the bus; may be called twice."""
        if self._bus is not None and self._running:
            self._send_command(ENABLE if self.drive_state == DriveState.ENABLED else 0, 0)
            self._send_command(QUICK_STOP, 0)
        self._running = False
        if self._bus is not None:
            self._bus.shutdown()
            self._bus = None

    def _open(self) -> None:
        can = can_package()
        self._bus = open_can(self._config)
        self._message = can.Message
        self._can_errors = (can.CanError, OSError)

    def _reopen(self, now: float) -> None:
        if now - self._retry_s < _RETRY_S:
            return
        self._retry_s = now
        try:
            self._open()
        except UserError:
            return  # not back yet

    def _lose(self) -> None:
        self._retry_s = self._clock()
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.shutdown()

    def _take(self, kind: int, data: bytes) -> None:
        if kind == 0x180 and len(data) == _STATUS_POSITION.size:
            status, position = _STATUS_POSITION.unpack(data)
            self.drive_state = drive_state(status)
            self._position = position / self._units_per_rad
            if self.drive_state == DriveState.ENABLED:
                self._good_s = self._clock()
        elif kind == 0x280 and len(data) == _VELOCITY.size:
            self._velocity = _VELOCITY.unpack(data)[0] / self._units_s_per_rad

    def _send_command(self, control: int, velocity_units_s: int) -> None:
        self._send(0x200 + self._config.node, _COMMAND.pack(control, velocity_units_s))

    def _send(self, identifier: int, data: bytes) -> None:
        if self._bus is None:
            return
        try:
            self._bus.send(self._message(arbitration_id=identifier, data=data, is_extended_id=False))
        except self._can_errors:
            self.send_failures += 1  # the queue is full or the bus is off: the state's age shows it
