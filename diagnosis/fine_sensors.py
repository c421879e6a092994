"""Sensors that are finer than the simulation, or the tracker, is taken to be right (`noise.LEAST`).

A drive that takes a command some milliseconds late, on a computer that is loaded, leaves the joint off by some tens of
microradians. In the joint that is less than a simulation reaches; in the image of an arm of 2 m it is a tenth of a
pixel, and the arm rings with it. Where the encoder resolves it, the image is told by where the joint was.
A tracker's error with the place in the pixel ("pixel locking") shows where the image's noise is less.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.added import answer_of_mode
from stillarm.diagnosis.noise import LEAST
from stillarm.diagnosis.robust import bridged, in_differences, white_noise

Array = NDArray[np.float64]

_FINE = 0.5  # of the least level
_SAME = 1e-9  # rad: values that a file's rounding alone tells apart
_FEWEST = 200
_QUIET = 0.1  # of the pieces, which are as quiet as the image gets
_PIECE = 32  # frames


def is_fine_encoder(position: Array) -> bool:
    """Whether a joint's position, (n,) rad, NaN where unmeasured, has noise and steps well below its least level."""
    known = position[np.isfinite(position)]
    if len(known) < _FEWEST:
        return False
    steps = np.abs(np.diff(known))
    step = float(np.min(steps, initial=np.inf, where=steps > _SAME))
    noise = white_noise(known, 2)
    return bool(max(step, noise) < _FINE * LEAST["joint_position"])


def is_fine_image(displacement_px: Array) -> bool:
    """Whether an image's noise lies below what trackers stray: by fifth differences, which show hardly anything of a
    motion that is slow beside the frames, in the quietest pieces. displacement_px: (n,), NaN where unmeasured."""
    fifth = np.diff(displacement_px, 5)
    count = len(fifth) // _PIECE
    if count * _PIECE < _FEWEST:
        return False
    pieces = fifth[: count * _PIECE].reshape(count, _PIECE)
    whole = pieces[np.isfinite(pieces).all(axis=1)]
    if not len(whole):
        return False
    noise = np.sqrt(np.mean(whole**2, axis=1)) / in_differences(5)
    return float(np.quantile(noise, _QUIET)) < LEAST["displacement"]


def within_reach(measured: Array, simulated: Array) -> Array:
    """By how much the joint was elsewhere than simulated, rad, no more than a simulation is taken to be off; straight
    across what was not measured. Both: (n,) rad."""
    return np.clip(bridged(measured - simulated), -LEAST["joint_position"], LEAST["joint_position"])


def tip_moved(off: Array, modes: Array, length_m: float, step_s: float) -> Array:
    """What that does to the tip, m: the rigid arm turns with it, and each mode answers q'' + 2 z w q' + w^2 q = -p l a,
    a being off's second derivative (bilinear). off: (n,) rad; modes: (m, 3) frequency_hz, damping_ratio, participation.
    """
    moved = length_m * off
    for hz, damping, participation in modes:
        # q under a force's second derivative is q'' under the force
        _, q = answer_of_mode(-participation * length_m * (off - off[0]), hz, damping, step_s)
        moved = moved + q
    return np.asarray(moved)
