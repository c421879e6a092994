"""Time as the effects count it: from the recording's start."""

from math import inf


class EffectClock:
    """Seconds from the recording's start; zero before it. One clock is shared by all that it concerns."""

    def __init__(self, origin_s: float = 0.0) -> None:
        """origin_s: the recording's start on the simulation's own clock; inf while it is not known."""
        self.origin_s = origin_s

    @classmethod
    def waiting(cls) -> "EffectClock":
        """One that stands at zero until origin_s is set."""
        return cls(inf)

    def at(self, time_s: float) -> float:
        """Seconds from the start to an instant of the simulation's clock; zero before the start."""
        return max(0.0, time_s - self.origin_s)
