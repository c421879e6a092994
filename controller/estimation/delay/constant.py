"""The capture delay as a known constant [9]."""

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.model import Model
from stillarm.controller.estimation.estimate import DelayEstimate, Status


class ConstantDelay:
    """model.timing.capture_delay_s for every sample, never measured: its status stays unestimated."""

    def __init__(self, model: Model) -> None:
        """The standard deviation is the model's spread."""
        timing = model.timing
        self.estimate = DelayEstimate(timing.capture_delay_s, timing.capture_delay_std_s, Status.UNESTIMATED)

    def see_cycle(self, cycle: int, vibration: float) -> None:
        """Ignore the accelerometer."""

    def see_sample(self, sample: VisualSample, cycle: int, deflection_m: float) -> None:
        """Ignore the image."""
