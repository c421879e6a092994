"""The causes in the image, such as a lens that distorts or tracking that drifts."""

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.effects import laws_at
from stillarm.common.files.model import Model
from stillarm.simulation.arm.effect_clock import EffectClock

FloatArray = NDArray[np.float64]


class ImageEffects:
    """Shows a displacement d as d plus the contributions of the image's laws at the time of the exposure."""

    def __init__(self, model: Model, clock: EffectClock) -> None:
        """As the model's effects name them. clock: that of the exposures."""
        self._laws = laws_at(model, "image")
        self._clock = clock
        self.happens = bool(self._laws)

    def shown_px(self, displacements_px: FloatArray, times_s: FloatArray) -> FloatArray:
        """What the image shows of displacements, at instants of the simulation's clock; arrays of one shape."""
        since_start_s = np.maximum(0.0, times_s - self._clock.origin_s)
        added = sum(law(displacements_px, since_start_s) for law in self._laws)
        return np.asarray(displacements_px + added, dtype=np.float64)


def image_effects(model: Model, clock: EffectClock) -> ImageEffects | None:
    """Those of a model; None where there are none, or none of any size."""
    effects = ImageEffects(model, clock)
    return effects if effects.happens else None
