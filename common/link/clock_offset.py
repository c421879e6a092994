"""Offset and rate of another computer's clock against this one's, from the datagrams that are exchanged anyway.

The four times of the network time protocol (RFC 5905, section 8): a timestamp leaves here at t1 and is read there at
t2; the answer leaves there at t3 and is read here at t4. With the other clock ahead by o(t) = o + k t,

    forward  f = t2 - t1 =  o + k t + (way there)  >=  o(t)
    backward b = t4 - t3 = -o - k t + (way back)   >= -o(t)

Queues, and readers that look only now and then, make both longer, never shorter: the least of each second is near the
bare travel time. A straight line through these, for both directions with one k, gives skew, round trip A + B and offset
(A - B) / 2. That halving takes both ways as equally long; the offset can be wrong by half the round trip, not more.

The fit is made once a second, and in stages: each exchange after the second's end does one of them. All at once would
take 0.15 ms out of one 1 ms cycle. A stage takes a tenth of that; 65 frames a second are through within 0.15 s.
"""

from collections import deque
from collections.abc import Iterator
from math import inf, isfinite, nan, sqrt
from typing import NamedTuple

from stillarm.common.datagrams.visual_sample import LinkTimes

_SECONDS = 30  # of which the least values are kept
_STEP_S = 0.001  # a clock that departs by more than this from what is possible was set
_FLOOR_S = 20e-6  # what a minimum of a second is uncertain by at the least
_OUTLIER = 3.0


class ClockEstimate(NamedTuple):
    """The other clock minus this one, s, at `time_s` of this one; its rate minus one; the round trip, s.

    NaN where nothing is known yet; offset_std_s without the unknown asymmetry, at most round_trip_s / 2.
    """

    time_s: float = nan
    offset_s: float = nan
    offset_std_s: float = nan
    skew: float = nan
    skew_std: float = nan
    round_trip_s: float = nan


class _Least(NamedTuple):
    """The least forward and backward time of a second, and when each was."""

    forward_at_s: float
    forward_s: float
    backward_at_s: float
    backward_s: float


_EMPTY = _Least(nan, inf, nan, inf)


class ClockOffset:
    """Offset, skew and round trip out of exchanged times; bounded in memory and work."""

    def __init__(self) -> None:
        """Knows nothing yet."""
        self.estimate = ClockEstimate()
        self.steps = 0
        """How often the other clock was set, or replaced by another computer's."""
        self._second = -1
        self._least = _EMPTY
        self._closed: deque[_Least] = deque(maxlen=_SECONDS)
        self._fit: Iterator[ClockEstimate | None] | None = None
        self._to_fit = False  # a second has closed since the fit under way began

    def add(self, times: LinkTimes, received_s: float) -> None:
        """Take one exchange; received_s: when its answer was read, on this clock. Times that are not finite are passed
        over. Each call does at most one stage of the fit.
        """
        forward, backward = times.received_s - times.sent_s, received_s - times.answered_s
        if not isfinite(forward + backward):
            return
        self._advance_fit()
        second = int(received_s)
        if second != self._second:
            if self._least is not _EMPTY:
                self._close()
            self._second, self._least = second, _EMPTY
        least = self._least
        if forward < least.forward_s:
            least = least._replace(forward_at_s=times.sent_s, forward_s=forward)
        if backward < least.backward_s:
            least = least._replace(backward_at_s=received_s, backward_s=backward)
        self._least = least

    def reset(self) -> None:
        """Forget everything: it is another process that answers now."""
        self._closed.clear()
        self._least, self._second = _EMPTY, -1
        self._fit, self._to_fit = None, False
        self.estimate = ClockEstimate()

    def _close(self) -> None:
        least, known = self._least, self.estimate
        if self._closed:
            expected = known.offset_s
            if isfinite(known.skew):
                expected += known.skew * (least.backward_at_s - known.time_s)
            if expected > least.forward_s + _STEP_S or expected < -least.backward_s - _STEP_S:
                self._closed.clear()
                self.steps += 1
                self._fit = None  # of a clock that goes no longer
        self._closed.append(least)
        self._to_fit = True

    def _advance_fit(self) -> None:
        if self._fit is None:
            if not self._to_fit:
                return
            self._fit, self._to_fit = _fit_in_stages(list(self._closed)), False
        estimate = next(self._fit)
        if estimate is not None:
            self._fit, self.estimate = None, estimate


def _fit_in_stages(seconds: list[_Least]) -> Iterator[ClockEstimate | None]:
    """A line with one slope through both directions; seconds that queued throughout are left out.

    Yields None between two stages, each one pass over the seconds, and the estimate at the end.
    """
    used = seconds
    for _ in range(3):
        line = _line(used)
        yield None
        residuals = [_residuals(line, second) for second in used]
        spread = sorted(max(abs(f), abs(b)) for f, b in residuals)
        bound = max(_OUTLIER * spread[len(spread) // 2], _FLOOR_S)
        kept = [s for s, (f, b) in zip(used, residuals, strict=True) if max(f, b) <= bound]
        if len(kept) == len(used) or len(kept) < 3:
            break
        used = kept
        yield None
    line = _line(used)
    yield None
    yield _estimate(line, used)


class _Line(NamedTuple):
    origin_s: float
    forward_s: float
    backward_s: float
    skew: float
    spread_s2: float  # sum of squared times about their means


def _line(seconds: list[_Least]) -> _Line:
    n, origin = len(seconds), seconds[-1].backward_at_s
    mean_tf = sum(s.forward_at_s - origin for s in seconds) / n
    mean_tb = sum(s.backward_at_s - origin for s in seconds) / n
    mean_f = sum(s.forward_s for s in seconds) / n
    mean_b = sum(s.backward_s for s in seconds) / n
    spread = both = 0.0
    for s in seconds:
        tf, tb = s.forward_at_s - origin - mean_tf, s.backward_at_s - origin - mean_tb
        spread += tf * tf + tb * tb
        both += tf * (s.forward_s - mean_f) - tb * (s.backward_s - mean_b)
    skew = both / spread if n >= 3 else 0.0
    return _Line(origin, mean_f - skew * mean_tf, mean_b + skew * mean_tb, skew, spread)


def _residuals(line: _Line, second: _Least) -> tuple[float, float]:
    return (
        second.forward_s - line.forward_s - line.skew * (second.forward_at_s - line.origin_s),
        second.backward_s - line.backward_s + line.skew * (second.backward_at_s - line.origin_s),
    )


def _estimate(line: _Line, seconds: list[_Least]) -> ClockEstimate:
    n = len(seconds)
    squares = sum(f * f + b * b for f, b in (_residuals(line, s) for s in seconds))
    variance = max(squares / max(1, 2 * n - 3), _FLOOR_S * _FLOOR_S)
    known = n >= 3
    return ClockEstimate(
        time_s=line.origin_s,
        offset_s=0.5 * (line.forward_s - line.backward_s),
        offset_std_s=sqrt(variance / n * 2.0),  # at the line's end: twice that of its middle, in variance
        skew=line.skew if known else nan,
        skew_std=sqrt(variance / line.spread_s2) if known else nan,
        round_trip_s=line.forward_s + line.backward_s,
    )
