"""The scene before the simulated camera: a seeded, band-limited texture that repeats far outside the image."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatImage = NDArray[np.float32]

CUTOFF = 0.25
"""Highest spatial frequency of the texture, cycles per pixel: half of what the pixels could carry, so that a
short interpolation kernel shifts the texture by any fraction of a pixel without a trace of error."""

_TAPER_FROM = 0.15  # cycles per pixel: above it the spectrum falls off, lest edges ring
_COARSEST = 1.0 / 128.0  # cycles per pixel: coarser structure would only be uneven light
_LEAST_PERIOD = 4096
_MARGIN = 256
_STREAM = 0x5CE7E
_MIDDLE, _REACH = 128.0, 100.0  # grey levels; what is left to 0 and 255 is for the read-out noise


@dataclass(frozen=True, slots=True)
class Scene:
    """A texture that repeats every `period` columns.

    texture: grey levels, shape (height, period + width + a margin), float32; the columns beyond `period` are
    the first ones again, so that any image is one slice.
    """

    texture: FloatImage
    period: int

    def columns(self, first: int, count: int) -> FloatImage:
        """Columns first .. first + count - 1 of the endless scene, shape (height, count); mostly a view."""
        start = first % self.period
        if start + count <= self.texture.shape[1]:
            return self.texture[:, start : start + count]
        return np.take(self.texture, np.arange(start, start + count) % self.period, axis=1)


def make_scene(width: int, height: int, seed: int) -> Scene:
    """A scene for images of `width` by `height`; the same seed gives the same scene.

    Noise with a spectrum that falls as 1/f (as much contrast in every octave, so that a pyramid's coarse
    levels have something to see as well), pressed into patches by tanh, and then cut off at CUTOFF: a finite
    sum of waves that is periodic in both directions, and so known exactly between its pixels. The period is
    at least 4096 columns and at least twice the image's width.
    """
    period = max(_LEAST_PERIOD, 1 << (2 * width - 1).bit_length())
    noise = np.random.default_rng((seed, _STREAM)).standard_normal((height, period), dtype=np.float32)
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(period)[None, :]).astype(np.float32)
    taper = np.clip((CUTOFF - frequency) / (CUTOFF - _TAPER_FROM), 0.0, 1.0)
    low_pass = (taper * taper * (3.0 - 2.0 * taper)).astype(np.float32)
    octaves = np.where(frequency < _COARSEST, 0.0, low_pass / np.maximum(frequency, _COARSEST)).astype(
        np.float32
    )

    rough = _filtered(noise, octaves)
    texture = _filtered(np.tanh(1.5 * rough / rough.std()), np.where(frequency == 0.0, 0.0, low_pass))
    texture *= _REACH / np.abs(texture).max()
    texture += _MIDDLE
    repeated = np.concatenate((texture, texture[:, : width + _MARGIN]), axis=1)
    return Scene(np.ascontiguousarray(repeated, dtype=np.float32), period)


def _filtered(image: FloatImage, response: FloatImage) -> FloatImage:
    return np.fft.irfft2(np.fft.rfft2(image) * response, s=image.shape).astype(np.float32)
