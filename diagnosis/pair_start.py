"""Where to start for a pair of input and output of which no model tells anything: at the largest resonance."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Mode, Model
from stillarm.diagnosis.measured import Measured

Array = NDArray[np.float64]

_PIECES = 16


def with_resonance_of(measured: Measured, model: Model) -> Model:
    """The model with one mode at the peak of |cross spectrum| / input's power (H1 estimate; Welch's means), and the
    damping ratio that the width of the peak tells."""
    force, out = measured.force, np.nan_to_num(measured.deflection)
    n = max(256, len(out) // _PIECES)
    window = np.hanning(n)
    cross, power = np.zeros(n // 2 + 1, complex), np.zeros(n // 2 + 1)
    for start in range(0, len(out) - n + 1, n // 2):
        u = np.fft.rfft((force[start : start + n] - force.mean()) * window)
        y = np.fft.rfft((out[start : start + n] - out.mean()) * window)
        cross += np.conj(u) * y
        power += np.abs(u) ** 2
    hz = np.fft.rfftfreq(n, measured.cycle_s)
    driven = power > 1e-4 * power.max()
    gain: Array = np.where(driven, np.abs(cross) / np.maximum(power, 1e-300), 0.0)
    gain[:2] = 0.0
    top = int(np.argmax(gain))
    above = np.flatnonzero(gain > gain[top] / 2.0**0.5)
    near = above[(above > top - n // 20) & (above < top + n // 20)]
    width = float(hz[near[-1]] - hz[near[0]]) if len(near) > 1 else float(hz[1])
    damping = min(max(0.5 * width / max(float(hz[top]), 1e-9), 0.002), 0.3)
    mode = Mode(frequency_hz=float(hz[top]), damping_ratio=damping)
    return msgspec.structs.replace(model, arm=msgspec.structs.replace(model.arm, modes=[mode]))
