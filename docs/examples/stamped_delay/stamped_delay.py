"""The delay by the camera's own stamps, whose clock has an unknown offset: the model's mean delay stands in for it."""

from math import isfinite, sqrt

import stillarm

WINDOW = 500  # frames of the running mean: long beside the jitter, short beside the drift of two clocks


class StampedDelay:
    """delay_k = d + x_k - mean(x), where x_k = reading - stamp of frame k, and d is the model's mean delay."""

    def __init__(self, model: stillarm.Model) -> None:
        self._timing = model.timing
        self._mean_s, self._frames = 0.0, 0
        prior = model.timing.capture_delay_s, model.timing.capture_delay_std_s
        self.estimate = stillarm.DelayEstimate(*prior, stillarm.Status.UNESTIMATED)

    def see_cycle(self, cycle: int, vibration: float) -> None:
        """The accelerometer's deflection in each cycle, m: not used."""

    def see_sample(self, sample: stillarm.VisualSample, cycle: int, deflection_m: float) -> None:
        """A visual sample in the cycle that read it, with the deflection that it shows, m."""
        if not isfinite(sample.captured_s):
            self.estimate = self.estimate._replace(status=stillarm.Status.HELD)
            return
        apart_s = cycle * self._timing.cycle_s - sample.captured_s
        self._frames = min(self._frames + 1, WINDOW)
        self._mean_s += (apart_s - self._mean_s) / self._frames
        delay_s = self._timing.capture_delay_s + apart_s - self._mean_s
        std_s = self._timing.capture_delay_std_s / sqrt(self._frames)
        self.estimate = stillarm.DelayEstimate(delay_s, std_s, stillarm.Status.ESTIMATED)


method = stillarm.with_sine_prediction(StampedDelay)
