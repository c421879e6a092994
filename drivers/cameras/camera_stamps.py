"""The instant that a camera's time stamp refers to, and its conversion to mid-exposure, for every camera.

| backend | reference | source |
|---|---|---|
| V4L2 through OpenCV | start of exposure | USB video class; others differ, and OpenCV hides the flag that says so |
| Basler | start of exposure | Basler, for its ace cameras; a chunk's stamp may be chosen |
| GenICam, Aravis | start of exposure | not standardised; most cameras latch at the start of exposure |
| IDS peak | start of exposure | IDS, for uEye+ U3 and GV; XCP, XLE, XLS are unsuitable for exact timing |
| IDS uEye, USB 2 | end of transfer | IDS; the paper's camera |
| IDS uEye, USB 3 and GigE | end of exposure | IDS: start of read-out, in freerun |
| libcamera | start of exposure | of the first row; its own sources disagree: calibrate |
| simulated | mid-exposure | ours |

The remaining error is a constant, on which no estimator relies. Set camera.stamp_reference if the table is wrong for a
camera.
"""

from enum import StrEnum
from math import isfinite

MAX_AGE_S = 5.0


class StampReference(StrEnum):
    """The instant that a stamp refers to."""

    EXPOSURE_START = "exposure_start"
    MID_EXPOSURE = "mid_exposure"
    EXPOSURE_END = "exposure_end"
    TRANSFER_END = "transfer_end"


_EXPOSURES_TO_MID = {
    StampReference.EXPOSURE_START: 0.5,
    StampReference.MID_EXPOSURE: 0.0,
    StampReference.EXPOSURE_END: -0.5,
    StampReference.TRANSFER_END: -0.5,  # plus the transfer, an unknown constant
}


def mid_exposure_s(stamp_s: float, reference: StampReference, exposure_s: float | None) -> float:
    """The instant of mid-exposure on the stamp's clock. An unknown exposure counts as zero, an error of half of it."""
    return stamp_s + _EXPOSURES_TO_MID[reference] * (exposure_s or 0.0)


class StampGate:
    """Accepts stamps on the monotonic clock that precede their reading shortly and increase."""

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


class DeviceStampGate:
    """Accepts stamps of a camera's own clock that are above zero and increase."""

    def __init__(self) -> None:
        """Nothing has been seen yet."""
        self._last = 0.0

    def accept(self, stamp_s: float | None) -> float | None:
        """The stamp, s, if it is valid; otherwise None. After a clock was set back, stamps count from there on."""
        if stamp_s is None or not isfinite(stamp_s) or stamp_s <= 0.0:
            return None
        rising = stamp_s > self._last
        self._last = stamp_s
        return stamp_s if rising else None
