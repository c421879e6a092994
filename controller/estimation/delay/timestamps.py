"""The capture delay by the exchange of timestamps: eq. 1 of the paper."""

from math import sqrt

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import DelayEstimate, Status


class TimestampDelay:
    """Delta = (n_c - n_i) tau_c, separately for each sample.

    n_i is the start of the supervisor's cycle. The exposure within that cycle, or before it, is unknown by a frame. The
    stated standard deviation is that of a uniform distribution two frame periods wide.
    """

    def __init__(self, model: Model) -> None:
        """The prior delay is used until the first stamped sample."""
        self._cycle_s = model.timing.cycle_s
        self._std_s = 2.0 / model.camera.frame_rate_hz / sqrt(12.0)
        self.estimate = DelayEstimate(
            model.timing.capture_delay_s, model.timing.capture_delay_std_s, Status.UNESTIMATED
        )

    def see_cycle(self, cycle: int, vibration: float) -> None:
        """Ignore the accelerometer."""

    def see_sample(self, sample: VisualSample, cycle: int, deflection_m: float) -> None:
        """Update the delay from a sample read in `cycle`; a sample without a timestamp leaves it unchanged."""
        if 0 <= sample.started_cycle <= cycle:
            delay = (cycle - sample.started_cycle) * self._cycle_s
            self.estimate = DelayEstimate(delay, self._std_s, Status.ESTIMATED)
        else:
            self.estimate = self.estimate._replace(status=Status.HELD)
