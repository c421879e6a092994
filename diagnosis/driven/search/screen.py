"""Which starts are worth a fit: how much of the residual one simulation from each would explain, to first order.

The change that a start makes in all channels is one direction. What the fit's own numbers and the blocks' states can
make of it is projected out; the rest, scaled freely, takes away so much of the squared residual (Rao's score test).
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, levels_of_fit, linearised
from stillarm.diagnosis.driven.fitting.gauss_newton import orthonormal
from stillarm.diagnosis.driven.fitting.showing import shown

Array = NDArray[np.float64]

_LEAST_LEFT = 1e-4  # of a direction, once the fit's own are taken out: less is rounding


class Screen:
    """A fit with its derivatives, against which starts are tried."""

    def __init__(self, fitted: DrivenFit) -> None:
        """Works out the derivatives once."""
        self._fit = fitted
        self._sigma = levels_of_fit(fitted)
        bounds = fitted.box.stack.bounds
        trains = [
            (one, at) for one, at in zip(linearised(fitted, self._sigma), bounds, strict=True) if one.trains
        ]
        self._bases = [(one.basis, *at) for one, at in trains]
        residual = np.concatenate([one.free[1] for one, _ in trains])
        columns = np.concatenate([one.free[0] for one, _ in trains])
        self._own = orthonormal(columns) if fitted.free else np.zeros((len(residual), 0))
        self._residual = residual - self._own @ (self._own.T @ residual)
        self._base = self._outputs(fitted, {})

    def share(self, start: dict[str, float]) -> tuple[float, float]:
        """How much of the squared residual a start's direction explains, 0 to 1, and how far along it that is: 1 at the
        start itself."""
        return self._explained(self._outputs(self._fit, start) - self._base)

    def share_from(
        self, begun: DrivenFit, zero: dict[str, float], start: dict[str, float]
    ) -> tuple[float, float]:
        """The same in another box, whose own simulation at `zero` is what the start is compared with."""
        return self._explained(self._outputs(begun, start) - self._outputs(begun, zero))

    def _outputs(self, fitted: DrivenFit, start: dict[str, float]) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):
            told = shown(fitted.box, {**fitted.numbers, **start}, fitted.states, self._sigma)
            return told if fitted.box.stack.known is None else told * fitted.box.stack.known

    def _explained(self, change: Array) -> tuple[float, float]:
        if not np.isfinite(change).all():
            return 0.0, 1.0
        moved = self._projected(change)
        size = float(moved @ moved)
        moved = moved - self._own @ (self._own.T @ moved)
        left, total = float(moved @ moved), float(self._residual @ self._residual)
        if left <= _LEAST_LEFT**2 * size or left == 0.0 or total == 0.0:
            return 0.0, 1.0
        along = float(moved @ self._residual)
        return along**2 / left / total, along / left

    def _projected(self, change: Array) -> Array:
        """Of the blocks that train: without what their states can make of it."""
        parts = [(change[begins:ends], basis) for basis, begins, ends in self._bases]
        return np.concatenate([one - basis @ (basis.T @ one) for one, basis in parts])
