"""The tip's recent poses in shared memory: written by the simulated plant, read by the simulated camera."""

import struct

import numpy as np
from numpy.typing import NDArray

from stillarm.common.memory.shared_memory import SharedBlock

FloatArray = NDArray[np.float64]

_ROWS = 4096  # 4 s at 1 kHz: a frame is rendered within a fraction of a second of its exposure
_ROW = struct.Struct("<3d")
_HEADER_BYTES = 64
_COUNT_WORD = 1


class PoseNotYet(LookupError):
    """A pose was asked for that lies after the newest one written."""


class PoseNoLonger(LookupError):
    """A pose was asked for that lies before the oldest one still held."""


class PoseHistory:
    """A ring of rows (time_s, tip_position_m, tip_angle_rad): one writer, any number of readers.

    tip_position_m is s, the transverse position of the tip; tip_angle_rad is theta plus the slope of the
    tip. The header counts the rows ever written and moves on only after a row is whole; a reader takes the
    count before and after copying, and so knows whether the writer has come round meanwhile.
    """

    def __init__(self, name: str | None, *, create: bool = False, wait_s: float = 0.0) -> None:
        """Make the ring `name`, or open one that exists, waiting up to `wait_s` for it. `None`: private
        memory.

        Private memory serves a simulation in virtual time, where writer and reader are one process. Raises
        UserError when there is no ring to open.
        """
        self._block: SharedBlock | None = None
        if name is None:
            self._words = memoryview(bytearray(_HEADER_BYTES)).cast("Q")
            self._buffer = memoryview(bytearray(_ROWS * _ROW.size))
        else:
            self._block = SharedBlock(name, _ROWS * _ROW.size, create=create, wait_s=wait_s)
            self._words, self._buffer = self._block.words, self._block.buffer
        self._numbers = self._buffer.cast("d")
        self._count = self._written()

    def append(self, time_s: float, tip_position_m: float, tip_angle_rad: float) -> None:
        """Add a row; times must increase from row to row. For the one writer only."""
        _ROW.pack_into(self._buffer, self._count % _ROWS * _ROW.size, time_s, tip_position_m, tip_angle_rad)
        self._count += 1
        self._words[_COUNT_WORD] = self._count

    def newest_time_s(self) -> float:
        """Time of the newest row; minus infinity before the first one."""
        written = self._written()
        return float(self._numbers[3 * ((written - 1) % _ROWS)]) if written else float("-inf")

    def interpolate(self, times_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (m) and angles (rad) at times of any shape, linear between rows.

        Linear is enough: at 1 ms steps a vibration of 2.6 Hz is off by w^2 dt^2 / 8 = 3e-5 of its amplitude,
        and a joint accelerating with 20 rad/s^2 by 5 um at the end of 2 m. Raises PoseNotYet or PoseNoLonger.
        """
        times = np.asarray(times_s, dtype=np.float64)
        first, last = float(np.minimum.reduce(times, axis=None)), float(np.maximum.reduce(times, axis=None))
        written = self._written()
        if not written or last > self._time(written - 1):
            raise PoseNotYet(f"pose at {last:.6f} s: the newest is that at {self.newest_time_s():.6f} s")
        oldest = max(0, written - _ROWS + 1)  # the row before it may be in the course of being overwritten
        if first < self._time(oldest):
            raise PoseNoLonger(f"pose at {first:.6f} s: the oldest is that at {self._time(oldest):.6f} s")
        begin = self._last_at_or_before(first, oldest, written - 1)
        end = min(written - 1, self._last_at_or_before(last, begin, written - 1) + 1)
        rows = self._copy(begin, end + 1)
        if begin < self._written() - _ROWS + 1:
            raise PoseNoLonger(f"pose at {first:.6f} s: overwritten while it was read")
        positions = np.interp(times, rows[:, 0], rows[:, 1])
        return positions, np.interp(times, rows[:, 0], rows[:, 2])

    def replaced(self) -> bool:
        """Whether the writer has restarted with a new ring since this one was opened."""
        return self._block is not None and self._block.replaced()

    def close(self) -> None:
        """Release the memory; may be called twice."""
        self._numbers.release()
        if self._block is not None:
            self._block.close()

    def _written(self) -> int:
        return int(self._words[_COUNT_WORD])

    def _time(self, row: int) -> float:
        return float(self._numbers[3 * (row % _ROWS)])

    def _last_at_or_before(self, time_s: float, low: int, high: int) -> int:
        """The last row in [low, high] whose time is at most `time_s`, given that row `low` is such a one."""
        numbers = self._numbers
        if high > low:  # rows are spaced nearly evenly: begin around the place where it then would be
            begin, end = self._time(low), self._time(high)
            share = min(max((time_s - begin) / (end - begin), 0.0), 1.0)
            guess = low + int(share * (high - low))
            below, above = max(low, guess - 1), min(high, guess + 2)
            if self._time(below) <= time_s:
                low = below
            if self._time(above) > time_s:
                high = above - 1
        while low < high:
            middle = (low + high + 1) // 2
            if numbers[3 * (middle % _ROWS)] <= time_s:
                low = middle
            else:
                high = middle - 1
        return low

    def _copy(self, begin: int, end: int) -> FloatArray:
        """Rows [begin, end) as an array of its own, shape (end - begin, 3)."""
        start, stop = begin % _ROWS, (end - 1) % _ROWS + 1
        if start < stop:
            return np.array(self._numbers[3 * start : 3 * stop]).reshape(-1, 3)
        parts = (np.array(self._numbers[3 * start :]), np.array(self._numbers[: 3 * stop]))
        return np.concatenate(parts).reshape(-1, 3)
