"""Signals as flags that a loop looks at."""

import signal
from types import FrameType


class StopSignal:
    """SIGTERM and SIGINT: truthy once the process was asked to stop."""

    def __init__(self) -> None:
        """Takes over both; call it from the main thread."""
        self._stopped = False
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, self._stop)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        self._stopped = True

    def __bool__(self) -> bool:
        return self._stopped

    def is_set(self) -> bool:
        """Whether the process was asked to stop."""
        return self._stopped


class SignalFlag:
    """One signal that may come again and again."""

    def __init__(self, number: signal.Signals) -> None:
        """Takes it over; call it from the main thread."""
        self._came = False
        signal.signal(number, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._came = True

    def take(self) -> bool:
        """Whether it has come since the last call."""
        came, self._came = self._came, False
        return came
