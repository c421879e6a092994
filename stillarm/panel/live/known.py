"""The panel's knowledge of the loop: its words, their age, whether it is silent. Pure: rows and times in."""

from collections import deque
from math import inf, isfinite, nan

from stillarm.panel.live.telemetry import Row, Words

SILENT_S = 0.4  # without a datagram for this long, the loop or the way to it is gone
_SAME_CLOCK_S = 0.5
_FLOOR_OVER = 2000  # datagrams: a minute
_LINES = 50


class Known:
    """The newest of everything that is not a curve."""

    def __init__(self) -> None:
        """Nothing heard yet."""
        self.words = Words()
        self.damping_allowed = False
        self.time_s = nan
        """The newest sample's time, s on the controller's clock."""
        self.lines: deque[dict[str, object]] = deque(maxlen=_LINES)
        self._heard_s = -inf
        self._floors: deque[float] = deque(maxlen=_FLOOR_OVER)
        self._floor_s = inf

    def take(self, rows: list[Row], now_s: float) -> None:
        """Rows of one datagram that arrived at `now_s`, s on this computer's monotonic clock."""
        if rows:
            self._heard_s = now_s
        for row in rows:
            if row.words is not None:
                if row.words.origin_monotonic_s != self.words.origin_monotonic_s:
                    self._forget_floor()
                self.words = row.words
            elif row.log is not None:
                line = {"time_s": row.time_s, "level": row.log.level, "text": row.log.text}
                self.lines.append(line)
            elif row.fast is not None:
                self.damping_allowed = row.fast.damping_allowed
                if row.time_s < self.time_s:
                    self._forget_floor()
                self.time_s = row.time_s
        if isfinite(self.time_s):
            self._floors.append(now_s - self.time_s)
            self._floor_s = min(self._floor_s, self._floors[-1])

    def _forget_floor(self) -> None:
        """The controller was restarted: its clock has another zero."""
        self._floors.clear()
        self._floor_s = inf
        self.time_s = nan

    def silent(self, now_s: float) -> bool:
        """Whether nothing has been heard for SILENT_S."""
        return now_s - self._heard_s > SILENT_S

    def origin(self) -> tuple[float, bool]:
        """Cycle 0 on this computer's monotonic clock, s, and whether that is exact.

        A controller on the same computer says it. From another computer, whose clock has another zero, the least time
        between a sample and its arrival counts as no time at all: ages are then too small by that.
        """
        told = self.words.origin_monotonic_s
        if 0.0 <= self._floor_s - told < _SAME_CLOCK_S:
            return told, True
        return self._floor_s, False
