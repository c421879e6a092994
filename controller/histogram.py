"""Counts of durations by the microsecond, for a whole run, at the cost of one increment each."""

import numpy as np

_BINS = 20_000  # the last one takes everything longer


class MicrosecondHistogram:
    """Durations in bins of a microsecond; the greatest is kept exactly."""

    def __init__(self) -> None:
        """Empty."""
        self._counts = [0] * _BINS
        self._greatest_s = 0.0

    def add(self, duration_s: float) -> None:
        """Count one duration; negative ones count as zero."""
        self._greatest_s = max(self._greatest_s, duration_s)
        self._counts[min(max(int(duration_s * 1e6), 0), _BINS - 1)] += 1

    def summary(self) -> tuple[float, float, float, float]:
        """50th, 99th and 99.9th percentile, and the greatest, microseconds; zeros when empty."""
        total = np.cumsum(self._counts)
        if total[-1] == 0:
            return 0.0, 0.0, 0.0, 0.0
        p50, p99, p999 = (float(np.searchsorted(total, share * total[-1])) for share in (0.5, 0.99, 0.999))
        return p50, p99, p999, self._greatest_s * 1e6
