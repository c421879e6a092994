"""A camera's frame counter as a number that only grows: wraps undone, restarts and nonsense bridged."""

_LARGEST_STEP = 10_000  # frames; minutes without one are a restart


class FrameCounter:
    """Turns raw counts into increasing ones. `wrong` counts those that could not follow the one before."""

    def __init__(self, modulus: int = 0) -> None:
        """modulus: how many values the raw counter has before it repeats itself (65535 for GigE Vision's 16-bit block
        number, which leaves out 0); 0 for one that does not wrap.
        """
        self._modulus = modulus
        self._raw = self._count = -1
        self.wrong = 0

    def accept(self, raw: int) -> int:
        """The count of a frame with a raw count; a repeated, reversed or absurd one counts as the next."""
        if self._raw < 0:
            self._count = raw
        else:
            step = raw - self._raw
            if self._modulus and step < 0:
                step += self._modulus
            if not 0 < step <= _LARGEST_STEP:
                self.wrong += 1
                step = 1
            self._count += step
        self._raw = raw
        return self._count
