"""Whether the filters are consistent: innovations of images against their stated spread, and the dates against physics.

Implements Eq. 60 of docs/fused.md.

The normalised innovation squared has the mean 1 in a filter that knows its own error (Bar-Shalom, Li and Kirubarajan,
Estimation with Applications, 2001, section 5.4). A mean far above it says that the stated deviations are too small by
about its root. It does not say why. A camera's quartz is off by tens of ppm, and no frame is read before it is exposed:
if the dates contradict that, they are wrong.
"""

from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions


class Consistency:
    """Watches the most likely filter.

    doubtful: whether its deviations are too small. factor: by how much, at least 1. proven: whether it has been
    consistent for a while since it began.
    """

    def __init__(self, assumed: Assumptions = ASSUMPTIONS) -> None:
        """Nothing seen."""
        self._assumed = assumed.consistency
        self.begin(float("-inf"))

    @property
    def calm(self) -> bool:
        """Whether innovations have been as large as stated for a while."""
        return not self.doubtful and self._mean < self._assumed.settled

    def lost_for(self, time_s: float, patience_s: float) -> bool:
        """Whether the filters have been lost for so long."""
        return time_s - self._doubted_since_s > patience_s

    def begin(self, time_s: float) -> None:
        """The filters begin anew."""
        self._mean = 1.0
        self._begun_s = time_s
        self._doubted_since_s = float("inf")
        self._seen = 0
        self.doubtful = self.proven = False
        self.factor = 1.0

    def see(self, time_s: float, nis: float, skew: float, skew_std: float, delay_s: float) -> bool:
        """After an image: its normalised innovation squared, the clock's skew and its deviation, the frame's delay.

        Returns whether the filters are lost and should start again.
        """
        self._mean += (min(nis, self._assumed.largest_nis) - self._mean) / self._assumed.memory_frames
        impossible = delay_s < 0.0 or abs(skew) > self._assumed.most_skew + self._assumed.skew_stds * skew_std
        above = self._mean > (self._assumed.settled if self.doubtful else self._assumed.doubtful)
        self.doubtful = above or impossible
        self.factor = max(1.0, self._mean) ** 0.5 if self.doubtful else 1.0
        self._seen += 1
        self.proven = self.proven or (self.calm and self._seen > self._assumed.memory_frames)
        if not self.doubtful:
            self._doubted_since_s = float("inf")
            return False
        if self._mean < self._assumed.lost and not impossible:
            self._doubted_since_s = float("inf")
        self._doubted_since_s = min(self._doubted_since_s, time_s)
        patient = time_s - self._begun_s < self._assumed.patience_s
        return time_s - self._doubted_since_s > self._assumed.lost_after_s and not patient
