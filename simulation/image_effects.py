"""The causes that sit in the image: a lens that distorts, tracking that drifts."""

import numpy as np
from numpy.typing import NDArray

from common.effects import effect_of
from common.model import Model
from simulation.effect_clock import EffectClock

FloatArray = NDArray[np.float64]


class ImageEffects:
    """A displacement d shows as d (1 + c d^2) + rate t, at the time of the exposure."""

    def __init__(self, model: Model, clock: EffectClock) -> None:
        """As the model's effects name them. clock: that of the exposures."""
        lens, drift = effect_of(model, "lens_distortion"), effect_of(model, "tracking_drift")
        self._bend_per_px2: float = lens["coefficient_per_px2"] if lens else 0.0
        self._drift_px_per_s: float = drift["rate_px_per_s"] if drift else 0.0
        self._clock = clock
        self.happens = bool(self._bend_per_px2 or self._drift_px_per_s)

    def shown_px(self, displacements_px: FloatArray, times_s: FloatArray) -> FloatArray:
        """What the image shows of displacements, at instants of the simulation's clock; arrays of one shape."""
        drifted_s = np.maximum(0.0, times_s - self._clock.origin_s)
        bent = displacements_px * (1.0 + self._bend_per_px2 * displacements_px * displacements_px)
        return np.asarray(bent + self._drift_px_per_s * drifted_s, dtype=np.float64)


def image_effects(model: Model, clock: EffectClock) -> ImageEffects | None:
    """Those of a model; None where there are none, or none of any size."""
    effects = ImageEffects(model, clock)
    return effects if effects.happens else None
