"""A scene whose truth is exact: a sum of random plane waves, evaluated analytically at any
displacement and rotation.
"""

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
SHAPE = (480, 640)


class SinusoidScene:
    """Grey values 128 + sum of waves with wavelengths between `shortest` and `longest` px, all directions."""

    def __init__(self, seed: int, shortest: float = 6.0, longest: float = 80.0, waves: int = 36) -> None:
        """contrast: 40 grey levels, standard deviation."""
        random = np.random.default_rng(seed)
        length = np.exp(random.uniform(np.log(shortest), np.log(longest), waves))
        angle = random.uniform(0.0, 2.0 * np.pi, waves)
        self._kx = 2.0 * np.pi / length * np.cos(angle)
        self._ky = 2.0 * np.pi / length * np.sin(angle)
        self._phase = random.uniform(0.0, 2.0 * np.pi, waves)
        self._amplitude = 40.0 * np.sqrt(2.0 / waves)

    def at(
        self,
        dx: float,
        dy: float,
        rotation: float = 0.0,
        shape: tuple[int, int] = SHAPE,
        smear: tuple[float, float] = (0.0, 0.0),
    ) -> NDArray[np.float32]:
        """The image when the scene point p, about the centre, is at R(rotation) p + (dx, dy).

        smear: motion over the exposure, px: each wave is attenuated by its mean over that line, sinc exactly.
        """
        height, width = shape
        x, y = np.arange(width) - 0.5 * (width - 1), np.arange(height) - 0.5 * (height - 1)
        c, s = np.cos(rotation), np.sin(rotation)
        kx, ky = c * self._kx - s * self._ky, s * self._kx + c * self._ky
        strength = self._amplitude * np.sinc((kx * smear[0] + ky * smear[1]) / (2.0 * np.pi))
        u, v = np.outer(kx, x - dx), np.outer(ky, y - dy) + self._phase[:, None]
        down = np.concatenate([strength[:, None] * np.cos(v), -strength[:, None] * np.sin(v)])
        along = np.concatenate([np.cos(u), np.sin(u)])  # cos(u + v) = cos u cos v - sin u sin v
        return np.asarray(128.0 + down.astype(np.float32).T @ along.astype(np.float32))


def photographed(grey: NDArray[np.float32], random: np.random.Generator, noise: float = 2.0) -> Image:
    """The image with sensor noise, rounded and clipped to uint8."""
    return np.clip(np.rint(grey + noise * random.standard_normal(grey.shape, np.float32)), 0, 255).astype(
        np.uint8
    )
