"""The operator's requests, by signal, switch or datagram, as bits of stillarm.controller.safety.table.Operator."""

import os

from stillarm.common.files.configuration import Safety
from stillarm.common.process.stop_signal import SignalFlag
from stillarm.common.user_error import UserError, reason_of
from stillarm.controller.safety.table import Operator


class EmergencyInput:
    """A file whose first byte is an emergency switch, such as a GPIO's value. An unreadable file counts as a stop."""

    def __init__(self, safety: Safety) -> None:
        """Opens nothing; start() does."""
        self._path = safety.emergency_stop_input
        self._stops_at = safety.emergency_stop_value.encode()
        self._descriptor = -1

    def start(self) -> None:
        """Open the file. Raises UserError with a remedy."""
        if not self._path:
            return
        try:
            self._descriptor = os.open(self._path, os.O_RDONLY)
        except OSError as error:
            raise UserError(
                f"controller.safety.emergency_stop_input = {self._path!r}: cannot be opened "
                f"({reason_of(error)}); name the file of the switch, such as "
                "/sys/class/gpio/gpio17/value, or leave it empty"
            ) from None

    def pressed(self) -> bool:
        """Whether the switch requests a stop now."""
        if not self._path:
            return False
        try:
            value = os.pread(self._descriptor, 1, 0)
        except OSError:
            return True
        return value in (self._stops_at, b"")

    def close(self) -> None:
        """Release the file; may be called twice."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


class OperatorInput:
    """The switch and the signal; datagrams arrive at the reference's socket."""

    def __init__(self, safety: Safety, signalled: SignalFlag | None) -> None:
        """signalled: the emergency stop by signal, if the process has one."""
        self._input = EmergencyInput(safety)
        self._signalled = signalled

    def start(self) -> None:
        """Open the switch. Raises UserError with a remedy."""
        self._input.start()

    def asked(self) -> int:
        """The requests of this cycle."""
        if self._input.pressed() or (self._signalled is not None and self._signalled.take()):
            return int(Operator.EMERGENCY_STOP)
        return 0

    def close(self) -> None:
        """Release the switch; may be called twice."""
        self._input.close()
