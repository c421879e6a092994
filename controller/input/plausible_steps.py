"""Distinguishes a single wrong value from a real step of a signal, by comparison with the previous values."""


class PlausibleSteps:
    """Accepts a value near the last accepted one, or one that the preceding values confirm."""

    def __init__(self, slack: float, per_s: float, confirmed_by: int) -> None:
        """A step may be as large as slack + per_s * (time since the previous value), in the signal's unit.

        confirmed_by: number of consecutive values that agree with each other and confirm a step of the signal.
        """
        self._slack, self._per_s, self._confirmed_by = slack, per_s, confirmed_by
        self.moved = False
        """Whether the last accepted value is a new level that the preceding values have confirmed."""
        self.restart()

    def restart(self) -> None:
        """Accept the next value unconditionally."""
        self._last: tuple[float, float] | None = None  # value, time in s
        self._refused = (0.0, 0.0)
        self._agreeing = 0

    def accepts(self, value: float, time_s: float) -> bool:
        """Whether to use a finite value. time_s must not be before that of the last call."""
        last, self.moved = self._last, False
        if (
            not self._agreeing
            and last is not None
            and abs(value - last[0]) <= self._slack + self._per_s * (time_s - last[1])
        ):  # nearly always
            self._last = value, time_s
            return True
        agrees = self._agreeing > 0 and self._near(self._refused, value, time_s)
        if last is None or self._near(last, value, time_s):
            nearer = agrees and last is not None and abs(value - self._refused[0]) < abs(value - last[0])
            if not nearer:  # with time, the tolerance of the last level grows to include the other one
                self._last, self._agreeing = (value, time_s), 0
                return True
        self._agreeing = self._agreeing + 1 if agrees else 1
        self._refused = value, time_s
        if self._agreeing < self._confirmed_by:
            return False
        self._last, self._agreeing, self.moved = self._refused, 0, True
        return True

    def _near(self, before: tuple[float, float], value: float, time_s: float) -> bool:
        return abs(value - before[0]) <= self._slack + self._per_s * (time_s - before[1])
