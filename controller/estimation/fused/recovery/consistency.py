"""Whether the filters are consistent: innovations of images against their stated spread, and the dates against physics.

The normalised innovation squared has the mean 1 in a filter that knows its own error (Bar-Shalom, Li and Kirubarajan,
Estimation with Applications, 2001, section 5.4). A mean far above it says that the stated deviations are too small, by
about its root, whatever the cause. A camera's quartz is off by tens of ppm, and no frame is read before it is exposed:
where the dates say otherwise, they are wrong.
"""

_MEMORY_FRAMES = 30.0
_LARGEST = 30.0  # one image may not decide alone
_DOUBTFUL, _SETTLED = (
    2.4,
    1.6,
)  # mean of so many: by chance above the first once in some days; between them as it was
_MOST_SKEW = 400e-6  # of a clock that counts frames by a period found right, or that stamps them
_SKEW_STDS = 4.0
_LOST = 4.0  # mean of so many: stated deviations that are half of the errors are raised, not begun anew for
_LOST_AFTER_S = 1.0  # for so long in doubt: the filters are lost, and begin anew
_PATIENCE_S = 3.0  # after a beginning


class Consistency:
    """Watches the most likely filter.

    doubtful: whether its deviations are too small. factor: by how much, at least 1.
    """

    def __init__(self) -> None:
        """Nothing seen."""
        self.begin(float("-inf"))

    @property
    def calm(self) -> bool:
        """Whether innovations have been as large as stated for a while."""
        return not self.doubtful and self._mean < _SETTLED

    def lost_for(self, time_s: float, patience_s: float) -> bool:
        """Whether the filters have been lost for so long."""
        return time_s - self._doubted_since_s > patience_s

    def begin(self, time_s: float) -> None:
        """The filters begin anew."""
        self._mean = 1.0
        self._begun_s = time_s
        self._doubted_since_s = float("inf")
        self.doubtful = False
        self.factor = 1.0

    def see(self, time_s: float, nis: float, skew: float, skew_std: float, delay_s: float) -> bool:
        """After an image: its normalised innovation squared, the clock's skew and its deviation, the frame's delay.

        Returns whether the filters are lost, and had better begin anew.
        """
        self._mean += (min(nis, _LARGEST) - self._mean) / _MEMORY_FRAMES
        impossible = delay_s < 0.0 or abs(skew) > _MOST_SKEW + _SKEW_STDS * skew_std
        above = self._mean > (_SETTLED if self.doubtful else _DOUBTFUL)
        self.doubtful = above or impossible
        self.factor = max(1.0, self._mean) ** 0.5 if self.doubtful else 1.0
        if not self.doubtful:
            self._doubted_since_s = float("inf")
            return False
        if self._mean < _LOST and not impossible:
            self._doubted_since_s = float("inf")
        self._doubted_since_s = min(self._doubted_since_s, time_s)
        patient = time_s - self._begun_s < _PATIENCE_S
        return time_s - self._doubted_since_s > _LOST_AFTER_S and not patient
