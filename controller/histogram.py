"""Counts of durations for a whole run, at the cost of one increment each and with nothing that grows.

Bins of a microsecond up to 2048, then 64 to each doubling (1.6 %), up to 16 s: fixed, so that they may lie in memory
that another process reads.
"""

from array import array
from collections.abc import Sequence

_LINEAR = 2048
_PER_OCTAVE = 64
_FIRST_OCTAVE, _OCTAVES = 11, 13  # 2048 us = 2^11 us
BINS = _LINEAR + _PER_OCTAVE * _OCTAVES
WORDS = BINS + 1
"""8-byte words that a histogram takes: the greatest duration, ns, and the counts."""


def bin_of(microseconds: int) -> int:
    """The bin of a duration; negative ones count as zero, and the last bin takes everything longer."""
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
    """For each share the bin below which at least that share of the durations lies, us; zeros when empty."""
    total, seen, found = sum(counts), 0, [0.0] * len(shares)
    left = sorted(range(len(shares)), key=lambda place: -shares[place])
    for index, count in enumerate(counts):
        seen += count
        while left and count and seen >= shares[left[-1]] * total:
            found[left.pop()] = float(bin_start_us(index))
    return found


class MicrosecondHistogram:
    """Durations in such bins; the greatest is kept exactly."""

    def __init__(self, words: memoryview | None = None) -> None:
        """Count in `words`, WORDS words of format "Q", or in memory of its own; goes on from what they hold."""
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
        """From now on the greatest is that of what comes."""
        self._words[0] = 0

    def counts(self) -> list[int]:
        """The counts now."""
        return self._words[1:].tolist()

    def summary(self) -> tuple[float, float, float, float]:
        """50th, 99th and 99.9th percentile, and the greatest, microseconds; zeros when empty."""
        p50, p99, p999 = percentiles_us(self.counts(), (0.5, 0.99, 0.999))
        return p50, p99, p999, self._words[0] * 1e-3
