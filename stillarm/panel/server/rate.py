"""Rate limit for one address: a bucket that fills at a rate (token bucket). Pure: times in, answers out."""

from collections import OrderedDict

_MOST_ADDRESSES = 1024


class RateLimit:
    """One bucket for each address; the address that has been quiet for longest is forgotten first."""

    def __init__(self, per_s: float, burst: int) -> None:
        """per_s: requests a second in the long run; burst: at once after a pause."""
        self._per_s, self._burst = per_s, float(burst)
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def allows(self, address: str, now_s: float) -> bool:
        """Whether a request of `address` at `now_s` is within the limit; it counts if it is."""
        left, seen_s = self._buckets.pop(address, (self._burst, now_s))
        left = min(self._burst, left + max(0.0, now_s - seen_s) * self._per_s)
        allowed = left >= 1.0
        self._buckets[address] = (left - 1.0 if allowed else left, now_s)
        if len(self._buckets) > _MOST_ADDRESSES:
            self._buckets.popitem(last=False)
        return allowed
