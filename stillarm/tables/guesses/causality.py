"""Which of two columns is the input, where no name tells.

The impulse response from the true input to the output lies after time zero and rings. The response of the inverse, from
output to input, is short and sits around zero. Both come from the averaged cross spectrum (Welch 1967),
H = S_uy / (S_uu + eps), and are compared by the mean lag of their energy.
"""

from dataclasses import dataclass

import numpy as np

from stillarm.tables.guesses.spectra import Complex, Floats

_SEGMENT = 4096  # rows, at most a quarter of the record
_AVERAGED = 4096  # rows; a shorter record is one segment as it is: it may be one period of a periodic test
_RIDGE = 1e-3  # of the largest power: frequencies that the input does not excite say nothing
_LATE = 0.4  # share of the response's energy after zero, less that before: a response that rings
_EVEN = 0.25  # of the inverse's: it sits around zero
_AROUND = 2  # samples that count neither as before nor as after
_COHERENT = 0.5  # of an averaged record: below, the two have little to do with each other
_BROAD = 60.0  # frequencies that share the input's power: fewer say nothing about a response
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
    forward, backward = _responses(x, y)
    if forward.late > _LATE and abs(backward.late) < _EVEN and forward.lag > 1.0:
        return Causality(first, second, forward.lag, backward.lag)
    if backward.late > _LATE and abs(forward.late) < _EVEN and backward.lag > 1.0:
        return Causality(second, first, backward.lag, forward.lag)
    return None


@dataclass(frozen=True)
class _Response:
    """late: share of energy after zero, less that before; lag: mean lag of the energy, samples."""

    late: float = 0.0
    lag: float = 0.0


def _responses(x: Floats, y: Floats) -> tuple[_Response, _Response]:
    averaged = len(x) >= _AVERAGED
    segment = min(_SEGMENT, len(x) // 4) if averaged else len(x)
    window = np.hanning(segment) if averaged else np.ones(segment)
    power_x, power_y = np.zeros(segment // 2 + 1), np.zeros(segment // 2 + 1)
    cross = np.zeros(segment // 2 + 1, dtype=np.complex128)
    for start in range(0, len(x) - segment + 1, max(1, segment // 2)):
        part = slice(start, start + segment)
        a = np.fft.rfft(window * (x[part] - x[part].mean()))
        b = np.fft.rfft(window * (y[part] - y[part].mean()))
        power_x += np.abs(a) ** 2
        power_y += np.abs(b) ** 2
        cross += np.conj(a) * b
    both = float((power_x * power_y).sum())
    if both <= 0.0 or float((np.abs(cross) ** 2).sum()) < _COHERENT * both:
        return _Response(), _Response()
    return _response(cross, power_x, segment), _response(np.conj(cross), power_y, segment)


def _lines(power: Floats) -> float:
    """How many frequencies share the power: (sum p)^2 / sum p^2."""
    return float(power.sum() ** 2 / np.sum(power**2))


def _response(cross: Complex, power: Floats, segment: int) -> _Response:
    if _lines(power) < _BROAD:
        return _Response()
    impulse = np.fft.irfft(cross / (power + _RIDGE * power.max()), segment)
    reach = min(200, segment // 4)
    energy = np.concatenate([impulse[-reach:], impulse[: reach + 1]]) ** 2
    lags = np.arange(-reach, reach + 1)
    whole = max(float(energy.sum()), 1e-300)
    late = float(energy[lags > _AROUND].sum() - energy[lags < -_AROUND].sum()) / whole
    return _Response(late, float(energy @ lags) / whole)
