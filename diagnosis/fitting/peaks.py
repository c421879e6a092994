"""Frequencies at which a fit leaves most: where a further resonance, a line or a hum is looked for."""

import numpy as np

from stillarm.diagnosis.fitting.fitted import Fit

_PEAKS = 6  # of a spectrum, by height, and as many by height over the level about them
_LEAST_PERIODS = 3.0  # within the recording: a slower wave is a drift


def residual_peaks(last: Fit) -> dict[str, tuple[float, ...]]:
    """Frequencies, Hz, of the largest peaks of each channel's residual spectrum."""
    world = last.world
    found: dict[str, tuple[float, ...]] = {}
    for name in ("acceleration", "displacement", "deflection"):
        if name not in world.channels:
            continue
        residual = np.nan_to_num(world.channels[name] - last.predicted.channels[name])
        if name == "displacement":
            step = 1.0 / world.model.camera.frame_rate_hz
            instants = world.instants(last.vector)
            good = np.isfinite(instants)
            grid = np.arange(instants[good][0], instants[good][-1], step)
            residual = np.interp(grid, instants[good], residual[good])
        else:
            step = world.measured.cycle_s
        length = 4 * len(residual)
        power = np.abs(np.fft.rfft((residual - residual.mean()) * np.hanning(len(residual)), n=length)) ** 2
        hz = np.fft.rfftfreq(length, step)
        power[hz < max(0.1, _LEAST_PERIODS / world.measured.duration_s)] = 0.0
        # against the level around each line, so that a slope of the spectrum is no peak
        width = max(length // 200, 8)
        level = np.convolve(power, np.ones(2 * width + 1) / (2 * width + 1), "same")
        peaks: list[float] = []
        for order in (power.copy(), power / np.maximum(level, 1e-30)):
            for _ in range(_PEAKS):
                i = int(np.argmax(order))
                if order[i] <= 0.0:
                    break
                peaks.append(float(hz[i]))
                order[max(0, i - 10) : i + 11] = 0.0
        found[name] = tuple(dict.fromkeys(peaks))
    return found
