"""SIGTERM and SIGINT as a flag that a loop looks at."""

import signal
from types import FrameType


class StopSignal:
    """Truthy once the process was asked to stop."""

    def __init__(self) -> None:
        """Takes over SIGTERM and SIGINT; call it from the main thread."""
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
