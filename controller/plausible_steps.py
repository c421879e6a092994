"""Tells a lone wrong value from a signal that truly moved: values of one quantity, each checked against the last."""

_CONFIRMED_BY = 3  # values in a row that agree with each other: the signal has moved


class PlausibleSteps:
    """Accepts a value near the one accepted last, or one that the values before it confirm."""

    def __init__(self, slack: float, per_s: float) -> None:
        """A step may be as large as slack + per_s * (time since the value before), in the signal's unit."""
        self._slack, self._per_s = slack, per_s
        self.restart()

    def restart(self) -> None:
        """The next value is accepted whatever it is."""
        self._last: tuple[float, float] | None = None  # value, time in s
        self._refused = (0.0, 0.0)
        self._agreeing = 0

    def accepts(self, value: float, time_s: float) -> bool:
        """Whether to use a finite value of a time that is not before that of the last call."""
        last = self._last
        if last is None or self._near(last, value, time_s):
            self._last, self._agreeing = (value, time_s), 0
            return True
        agrees = self._agreeing > 0 and self._near(self._refused, value, time_s)
        self._agreeing = self._agreeing + 1 if agrees else 1
        self._refused = value, time_s
        if self._agreeing < _CONFIRMED_BY:
            return False
        self._last, self._agreeing = self._refused, 0
        return True

    def _near(self, before: tuple[float, float], value: float, time_s: float) -> bool:
        return abs(value - before[0]) <= self._slack + self._per_s * (time_s - before[1])
