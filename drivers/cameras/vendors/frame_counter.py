"""A camera's frame counter as an increasing number: undoes wraps, and bridges restarts and invalid values."""

_LARGEST_STEP = 10_000  # frames: a larger step counts as a restart


class FrameCounter:
    """Converts raw counts into increasing ones. `wrong` counts those that could not follow their predecessor."""

    def __init__(self, modulus: int = 0) -> None:
        """modulus: number of values before the raw counter repeats (65535 for GigE Vision's 16-bit block number, which
        skips 0); 0 for a counter that does not wrap.
        """
        self._modulus = modulus
        self._raw = self._count = -1
        self.wrong = 0

    def accept(self, raw: int) -> int:
        """The count of a frame from its raw count. A repeated, reversed or absurd one counts as the next number."""
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
