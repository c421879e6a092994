"""Counts of durations for a whole run, with one increment for each and constant memory.

The bins are 1 us wide up to 2048 us, then 64 for each doubling (1.6 %), up to 16 s. They are fixed, so that they may
lie in memory that another process reads.
"""

from array import array
from collections.abc import Sequence

_LINEAR = 2048
_PER_OCTAVE = 64
_FIRST_OCTAVE, _OCTAVES = 11, 13  # 2048 us = 2^11 us
BINS = _LINEAR + _PER_OCTAVE * _OCTAVES
WORDS = BINS + 1
"""Size of a histogram in 8-byte words: the greatest duration, ns, and the counts."""


def bin_of(microseconds: int) -> int:
    """The bin of a duration. Negative ones count as zero; the last bin contains everything longer."""
    if microseconds < _LINEAR:
        return max(microseconds, 0)
    octave = microseconds.bit_length() - 1
    place = (octave - _FIRST_OCTAVE) * _PER_OCTAVE + (microseconds >> (octave - 6)) - _PER_OCTAVE
    return min(_LINEAR + place, BINS - 1)


def bin_start_us(index: int) -> int:
    """The shortest duration that falls into a bin, us."""
    if index < _LINEAR:
        return index
    octave, part = divmod(index - _LINEAR, _PER_OCTAVE)
    return (_PER_OCTAVE + part) << (octave + _FIRST_OCTAVE - 6)


def percentiles_us(counts: Sequence[int], shares: Sequence[float]) -> list[float]:
    """For each share, the bin that contains that percentile of the durations, us; zeros if empty."""
    total, seen, found = sum(counts), 0, [0.0] * len(shares)
    left = sorted(range(len(shares)), key=lambda place: -shares[place])
    for index, count in enumerate(counts):
        seen += count
        while left and count and seen >= shares[left[-1]] * total:
            found[left.pop()] = float(bin_start_us(index))
    return found


class MicrosecondHistogram:
    """A histogram of durations; the greatest is kept exactly."""

    def __init__(self, words: memoryview | None = None) -> None:
        """Count in `words`, WORDS words of format "Q" whose contents are kept, or in private memory."""
        self._words = memoryview(array("Q", [0] * WORDS)) if words is None else words

    def add(self, duration_s: float) -> None:
        """Count one duration; negative ones count as zero."""
        words = self._words
        microseconds = int(duration_s * 1e6)
        words[1 + (microseconds if 0 <= microseconds < _LINEAR else bin_of(microseconds))] += 1
        nanoseconds = int(duration_s * 1e9)
        if nanoseconds > words[0]:  # noqa: PLR1730 - max() would cost a call in every cycle
            words[0] = nanoseconds

    @property
    def greatest_ns(self) -> int:
        """The greatest duration so far, ns."""
        return int(self._words[0])

    def forget_greatest(self) -> None:
        """Restart the search for the greatest duration."""
        self._words[0] = 0

    def counts(self) -> list[int]:
        """The present counts."""
        return self._words[1:].tolist()

    def summary(self) -> tuple[float, float, float, float]:
        """50th, 99th and 99.9th percentile and the maximum, us; zeros if empty."""
        p50, p99, p999 = percentiles_us(self.counts(), (0.5, 0.99, 0.999))
        return p50, p99, p999, self._words[0] * 1e-3
