"""The camera: what each exposure sees."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from tests.hidden_world.effects import Effect, rough_ramp
from tests.hidden_world.feeler import second_axis
from tests.hidden_world.rig import FINE, STEP_S, Rig

Array = NDArray[np.float64]


@dataclass
class _View:
    rig: Rig
    rows: Array
    image: Array
    """Image displacement on the fine grid, px, before the lens."""
    scale_m: float


def seen(rig: Rig, effects: tuple[Effect, ...], rows: Array, middle: Array, scale_m: float) -> Array:
    """Displacement of the exposures about `middle` (s), px, without noise: the mean over each exposure."""
    tip = rig.reach * rows[:, 6] + rows[:, 2] + rows[:, 4]
    view = _View(rig, rows, -rig.eye.px_per_m * tip, scale_m)
    for effect in effects:
        if effect.name in _BEFORE_LENS:
            _BEFORE_LENS[effect.name](view, effect)
    whole = np.concatenate([[0.0], np.cumsum(0.5 * (view.image[1:] + view.image[:-1])) * STEP_S])
    grid = np.arange(len(rows)) * STEP_S
    half = 0.5 * rig.eye.open_s
    if half > 0.0:
        out = (np.interp(middle + half, grid, whole) - np.interp(middle - half, grid, whole)) / (2.0 * half)
    else:
        out = np.interp(middle, grid, view.image)
    for effect in effects:
        if effect.name in _AFTER_LENS:
            out = _AFTER_LENS[effect.name](out, middle, effect)
    return np.asarray(out + rig.eye.centre_px)


def _tilt(v: _View, e: Effect) -> None:
    """Plain: rotation times (joint angle + slope of the tip); rough: the sine, and a slope of 0.97 of it."""
    slopes = v.rig.slopes
    slope = slopes[0] * v.rows[:, 2] + (slopes[1] * v.rows[:, 4] if len(slopes) > 1 else 0.0)
    angle = v.rows[:, 6] + (1.0 - 0.03 * e.detail) * slope
    v.image -= e["rotation_px_per_rad"] * (angle + e.detail * (np.sin(angle) - angle))


def _second_axis(v: _View, e: Effect) -> None:
    ticks = (len(v.rows) - 1) // FINE
    place = second_axis(v.rig, e, ticks, v.scale_m)[0]
    v.image -= (
        v.rig.eye.px_per_m * e["amount"] * np.interp(np.arange(len(v.rows)) / FINE, np.arange(ticks), place)
    )


def _loose(v: _View, e: Effect) -> None:
    """The mount rattles at its own frequency once the tip's acceleration overcomes what holds it."""
    tip = v.rows[:, 7]
    hold = 0.5 * float(np.std(tip))
    drive = tip - np.clip(tip, -hold, hold)
    w = 2.0 * pi * e["mount_hz"]
    pole = np.exp(STEP_S * w * (-0.06 + 1j))
    gain = STEP_S * abs(pole) * np.sin(w * STEP_S) / w
    rattle = lfilter([0.0, gain], [1.0, -2.0 * pole.real, abs(pole) ** 2], drive)
    v.image -= v.rig.eye.px_per_m * e["amount"] * rattle * (1.0 + 0.4 * np.sign(rattle))


def _drift(image: Array, middle: Array, e: Effect) -> Array:
    """From the first frame on."""
    if len(middle) == 0:
        return image
    grid = np.linspace(0.0, float(middle[-1]), 4000)
    out: Array = image + np.interp(middle, grid, rough_ramp(e, grid, e["rate_px_per_s"]))
    return out


def _lens(image: Array, middle: Array, e: Effect) -> Array:
    """Plain: d (1 + c d^2). Rough: the lens's centre is 3 px off, and a fifth-order term gives a tenth back."""
    c, off = e["coefficient_per_px2"], 3.0 * e.detail
    d = image - off
    far = float(np.max(np.abs(d))) or 1.0
    out: Array = d * (1.0 + c * d**2 * (1.0 - 0.1 * e.detail * (d / far) ** 2)) + off
    return out


def _pixel_locking(image: Array, middle: Array, e: Effect) -> Array:
    return np.asarray(image + e["amount"] * np.sin(2.0 * pi * image) / (2.0 * pi))


_BEFORE_LENS: dict[str, Callable[[_View, Effect], None]] = {
    "camera_tilt_coupling": _tilt,
    "second_axis": _second_axis,
    "loose_mount": _loose,
}
_AFTER_LENS: dict[str, Callable[[Array, Array, Effect], Array]] = {
    "lens_distortion": _lens,
    "tracking_drift": _drift,
    "pixel_locking": _pixel_locking,
}
