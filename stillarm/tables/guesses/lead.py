"""Which column leads which, by the peak of their cross-correlation.

    r(l) = sum x(n) y(n + l) / sqrt(sum x^2 sum y^2)

The peak is refined by a parabola through its neighbours. A second peak nearly as high (periodic signals) makes the lag
ambiguous, and it is not told.
"""

from dataclasses import dataclass

import numpy as np

from stillarm.tables.guesses.spectra import Floats, Spectra, without_line

SURE = 0.85
_CLEAR = 0.995  # of the peak: another local peak above makes the lag ambiguous
_SPREAD = 0.02  # of the record: lags beyond are not looked at
_GAIN = 2e-4  # by which the peak must exceed the correlation without lag


@dataclass(frozen=True)
class Lead:
    """`column` comes first; `follower` repeats it `lag` samples later. match: correlation at the peak, with sign."""

    column: str
    follower: str
    lag: float
    match: float


def leads(spectra: Spectra) -> list[Lead]:
    """For each column the one that it follows best, where that is clear."""
    names = list(spectra.samples)
    length = 1 << int(np.ceil(np.log2(max(2, 2 * spectra.rows))))
    centred = {name: without_line(values) for name, values in spectra.samples.items()}
    padded = {name: np.fft.rfft(values, length) for name, values in centred.items()}
    norms = {name: float(np.sqrt(values @ values)) for name, values in centred.items()}
    found: dict[str, Lead] = {}
    for index, first in enumerate(names):
        for second in names[index + 1 :]:
            if norms[first] == 0.0 or norms[second] == 0.0:
                continue
            correlation = np.fft.irfft(np.conj(padded[first]) * padded[second], length)
            lag, match = _peak(correlation / (norms[first] * norms[second]), spectra.rows)
            if abs(match) < SURE or abs(lag) < 0.3:
                continue
            ahead, behind = (first, second) if lag > 0.0 else (second, first)
            held = found.get(behind)
            if held is None or abs(match) > abs(held.match):
                found[behind] = Lead(ahead, behind, abs(lag), match)
    return list(found.values())


def _peak(correlation: Floats, rows: int) -> tuple[float, float]:
    reach = max(3, min(rows // 4, int(_SPREAD * rows) + 20))
    near = np.concatenate([correlation[-reach:], correlation[: reach + 1]])
    size = np.abs(near)
    top = int(np.argmax(size))
    if top in (0, len(near) - 1) or size[top] - size[reach] < _GAIN:
        return 0.0, float(near[top])
    local = (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])
    peaks = np.flatnonzero(local) + 1
    rivals = [p for p in peaks if abs(p - top) > 2 and size[p] > _CLEAR * size[top]]
    if rivals:
        return 0.0, float(near[top])
    before, here, after = size[top - 1], size[top], size[top + 1]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return top - reach + float(shift), float(near[top])
