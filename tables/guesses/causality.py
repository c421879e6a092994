"""Which of two columns is the input, where no name tells.

The impulse response from the true input to the output lies after time zero and rings. The response of the inverse, from
output to input, is short and sits around zero. Both come from the averaged cross spectrum (Welch 1967),
H = S_uy / (S_uu + eps), and are compared by the mean lag of their energy.
"""

from dataclasses import dataclass

import numpy as np

from stillarm.tables.guesses.spectra import Complex, Floats

_SEGMENT = 4096  # rows; a record shorter than two of them is one segment
_RIDGE = 1e-3  # of the largest power: frequencies that the input does not excite say nothing
_LATE = 1.5  # samples: mean lag of a response that rings
_REVERSE = 1.0  # samples: mean lag of an inverse
_LEAST_ROWS = 256


@dataclass(frozen=True)
class Causality:
    """input drives output. lag: mean lag of the response's energy, samples; lag_back: of the inverse's."""

    input: str
    output: str
    lag: float
    lag_back: float


def causality(first: str, x: Floats, second: str, y: Floats) -> Causality | None:
    """Which drives which; None where it does not show."""
    if len(x) < _LEAST_ROWS:
        return None
    forward, backward = _mean_lags(x, y)
    if forward > _LATE and abs(backward) < _REVERSE and forward > 3.0 * abs(backward):
        return Causality(first, second, forward, backward)
    if backward > _LATE and abs(forward) < _REVERSE and backward > 3.0 * abs(forward):
        return Causality(second, first, backward, forward)
    return None


def _mean_lags(x: Floats, y: Floats) -> tuple[float, float]:
    segment = _SEGMENT if len(x) >= 2 * _SEGMENT else len(x)
    window = (
        np.hanning(segment) if segment < len(x) else np.ones(segment)
    )  # a short record may be one period: as it is
    power_x, power_y = np.zeros(segment // 2 + 1), np.zeros(segment // 2 + 1)
    cross = np.zeros(segment // 2 + 1, dtype=np.complex128)
    for start in range(0, len(x) - segment + 1, max(1, segment // 2)):
        part = slice(start, start + segment)
        a = np.fft.rfft(window * (x[part] - x[part].mean()))
        b = np.fft.rfft(window * (y[part] - y[part].mean()))
        power_x += np.abs(a) ** 2
        power_y += np.abs(b) ** 2
        cross += np.conj(a) * b
    if not power_x.max() or not power_y.max():
        return 0.0, 0.0
    return _mean_lag(cross, power_x, segment), _mean_lag(np.conj(cross), power_y, segment)


def _mean_lag(cross: Complex, power: Floats, segment: int) -> float:
    response = np.fft.irfft(cross / (power + _RIDGE * power.max()), segment)
    reach = min(200, segment // 4)
    near = np.concatenate([response[-reach:], response[: reach + 1]]) ** 2
    return float(near @ np.arange(-reach, reach + 1) / max(float(near.sum()), 1e-300))
