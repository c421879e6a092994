"""Which of a driver's time stamps to believe. Their meaning differs by backend.

V4L2 through OpenCV gives the buffer's stamp in CAP_PROP_POS_MSEC: for USB video class cameras the start of
exposure, on CLOCK_MONOTONIC. Others give 0, a play time, or a wall clock that jumps. What is not plausible
is not a stamp.
"""

from math import isfinite

MAX_AGE_S = 5.0


class StampGate:
    """Passes stamps that lie on the monotonic clock, shortly before they are read, each later than the one
    before."""

    def __init__(self) -> None:
        """Nothing has been seen yet."""
        self._last = -1.0

    def accept(self, stamp_s: float, now_s: float) -> float | None:
        """The stamp, s, if it is plausible when read at now_s on the monotonic clock; None otherwise."""
        if (
            not isfinite(stamp_s)
            or not now_s - MAX_AGE_S < stamp_s <= now_s
            or stamp_s <= max(self._last, 0.0)
        ):
            return None
        self._last = stamp_s
        return stamp_s
