"""Images as the simulated camera takes them: motion during the exposure, shutter, read-out noise, 8 bits."""

from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.configuration import SimulatedScene
from stillarm.common.files.model import Camera
from stillarm.drivers.cameras.camera import GreyImage
from stillarm.simulation.camera.image_effects import ImageEffects
from stillarm.simulation.camera.image_motion import Interpolate, displacement_px, quadrature, sub_exposures
from stillarm.simulation.camera.scene import make_scene

FloatArray = NDArray[np.float64]

_HALF_TAPS = 5  # to either side; see _interpolation_kernel
_KAISER_SHAPE = 8.0
_KERNEL_STEPS = 4096  # looking up the nearest moves the scene by 1e-4 px at most
_BAND_STEP_PX = 0.04  # rows that a rolling shutter shifts by less are drawn together: at most 0.02 px off
_BAND_ROWS = 4  # but at least so many, lest a fast move cost more than its frame
_NOISE_OFFSETS = 1 << 20
_STREAM = 0x401CE


class Renderer:
    """Renders exposures of one camera in front of one scene. Pure: the same arguments give the same image.

    Every sub-exposure is the scene, shifted along a row; the sum of them all is therefore one filter along the rows,
    whose taps are the sum of the shifted interpolation kernels. An image with 16 sub-exposures therefore costs hardly
    more than one with a single exposure.
    """

    def __init__(
        self, camera: Camera, scene: SimulatedScene, seed: int, effects: ImageEffects | None = None
    ) -> None:
        """Makes the scene and a bank of noise: 20 MB for 640 x 480. OpenCV's threads are the caller's."""
        self._effects = effects
        self._camera = camera
        self._width, self._height = scene.width_px, scene.height_px
        self._scene = make_scene(scene.width_px, scene.height_px, seed)
        self._seed = seed
        random = np.random.default_rng((seed, _STREAM))
        pixels = _NOISE_OFFSETS + scene.width_px * scene.height_px
        self._noise = random.standard_normal(pixels, dtype=np.float32) * np.float32(scene.noise_grey_levels)
        self._clean = np.empty((scene.height_px, scene.width_px), dtype=np.float32)

    def render(self, interpolate: Interpolate, exposure_start_s: float, frame: int) -> GreyImage:
        """The image of exposure number `frame`, shape (height, width), which began at `exposure_start_s`.

        Exceptions of `interpolate` (PoseNotYet, PoseNoLonger) pass through.
        """
        camera = self._camera
        readout = camera.readout_s if camera.shutter == "rolling" else 0.0
        coarse = exposure_start_s + (camera.exposure_s + readout) * np.linspace(0.0, 1.0, 9)
        span = float(np.ptp(self._displacements(interpolate, coarse)))
        bands = min(self._height // _BAND_ROWS, max(1, ceil(span / _BAND_STEP_PX))) if readout > 0.0 else 1
        edges = np.arange(bands + 1) * self._height // bands
        rows = 0.5 * (edges[:-1] + edges[1:] - 1) if readout > 0.0 else np.zeros(1)

        fractions, weights = quadrature(sub_exposures(span))
        starts = exposure_start_s + rows / self._height * readout
        times = starts[:, None] + camera.exposure_s * fractions[None, :]
        displacements = self._displacements(interpolate, times)
        firsts, taps = _filters(displacements, weights)
        for top, bottom, first, row_taps in zip(edges[:-1], edges[1:], firsts, taps, strict=True):
            strip = self._scene.columns(int(first), self._width + len(row_taps) - 1)[top:bottom]
            filtered = cv2.filter2D(strip, cv2.CV_32F, row_taps[None, :], anchor=(0, 0))
            self._clean[top:bottom] = filtered[:, : self._width]

        offset = int(np.random.default_rng((self._seed, _STREAM, frame)).integers(_NOISE_OFFSETS))
        noise = self._noise[offset : offset + self._clean.size].reshape(self._clean.shape)
        return np.asarray(cv2.add(self._clean, noise, dtype=cv2.CV_8U), dtype=np.uint8)

    def _displacements(self, interpolate: Interpolate, times_s: FloatArray) -> FloatArray:
        """What the image shows, px, at instants."""
        displacements = displacement_px(self._camera, *interpolate(times_s))
        return displacements if self._effects is None else self._effects.shown_px(displacements, times_s)


def _filters(displacements: FloatArray, weights: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """The filter that draws each band's image: sum_j weights_j * scene(x - displacements_j).

    displacements: px, shape (bands, sub-exposures); weights: shape (sub-exposures). Returns the scene's
    column under each filter's first tap, when drawing image column 0, and the taps, shape (bands, taps).
    """
    places = -displacements
    firsts = np.floor(places.min(axis=1)).astype(np.int64) - _HALF_TAPS + 1
    count = int((np.floor(places.max(axis=1)) - firsts).max()) + _HALF_TAPS + 1
    distances = np.abs((places - firsts[:, None])[:, :, None] - np.arange(count))
    steps = np.minimum(distances * _KERNEL_STEPS + 0.5, len(_KERNEL) - 1).astype(np.int64)
    taps = np.einsum("j,bjn->bn", weights, _KERNEL[steps])
    return firsts, (taps / taps.sum(axis=1, keepdims=True)).astype(np.float32)


def _interpolation_kernel() -> FloatArray:
    """Right half of a sinc under Kaiser's window, 10 taps wide, at _KERNEL_STEPS places a pixel, and a zero.

    The scene ends at 0.25 cycles per pixel and its first image begins at 0.75, so that the kernel's edge, at
    0.5, has a quarter to either side to fall in: Kaiser's rule gives some 80 dB.
    """
    distance = np.arange(_HALF_TAPS * _KERNEL_STEPS + 1) / _KERNEL_STEPS
    window = np.i0(_KAISER_SHAPE * np.sqrt(1.0 - (distance / _HALF_TAPS) ** 2)) / np.i0(_KAISER_SHAPE)
    return np.append(np.sinc(distance) * window, 0.0)


_KERNEL = _interpolation_kernel()
