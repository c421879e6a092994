"""Spectra of a table's columns, computed once and compared pair by pair."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stillarm.tables.table import Values, as_floats

LONGEST = 32768  # rows that are compared; the liveliest stretch of a longer table
Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Spectra:
    """Fourier transforms of each column, shape (bins,), and the samples that they are of.

    states: without the line from the first to the last value; rates: without the mean. If y = dx/dt, then the line's
    slope is the mean of y, so that states and rates stay derivatives of each other, and no window is needed.
    windowed: without the line of least squares, under a Hann window, for second derivatives.
    omega: angular frequency of the bins, per sample.
    """

    states: dict[str, Complex]
    rates: dict[str, Complex]
    windowed: dict[str, Complex]
    omega: Floats
    samples: dict[str, Floats]
    rows: int


def spectra(columns: dict[str, Values]) -> Spectra:
    """Spectra of columns of one length. Gaps in a column are bridged by straight lines."""
    rows = len(next(iter(columns.values()))) if columns else 0
    whole = {name: _bridged(as_floats(values)) for name, values in columns.items()}
    start = _liveliest(whole, rows)
    samples = {name: values[start : start + LONGEST] for name, values in whole.items()}
    rows = min(rows, LONGEST)
    window = np.hanning(rows)
    return Spectra(
        states={name: np.fft.rfft(_closed(values)) for name, values in samples.items()},
        rates={name: np.fft.rfft(values - values.mean()) for name, values in samples.items()},
        windowed={name: np.fft.rfft(window * without_line(values)) for name, values in samples.items()},
        omega=np.asarray(2.0 * np.pi * np.fft.rfftfreq(max(1, rows)), dtype=np.float64),
        samples=samples,
        rows=rows,
    )


def only(held: Spectra, names: set[str]) -> Spectra:
    """The same for some of the columns."""
    return Spectra(
        {n: v for n, v in held.states.items() if n in names},
        {n: v for n, v in held.rates.items() if n in names},
        {n: v for n, v in held.windowed.items() if n in names},
        held.omega,
        {n: v for n, v in held.samples.items() if n in names},
        held.rows,
    )


def _closed(values: Floats) -> Floats:
    """Values without the line from their first to their last: they end where they begin."""
    closed: Floats = values - np.linspace(values[0], values[-1], len(values))
    return closed


def _bridged(values: Floats) -> Floats:
    there = np.isfinite(values)
    if there.all() or not there.any():
        return np.where(there, values, 0.0)
    index = np.arange(len(values))
    return np.interp(index, index[there], values[there])


def _liveliest(columns: dict[str, Floats], rows: int) -> int:
    """Start of the stretch of LONGEST rows in which the columns vary most, each by its own measure."""
    if rows <= LONGEST:
        return 0
    block = LONGEST // 4
    count = rows // block
    energy = np.zeros(count)
    for values in columns.values():
        spread = np.array([np.std(values[i * block : (i + 1) * block]) for i in range(count)])
        energy += spread / (spread.max() or 1.0)
    starts = np.convolve(energy, np.ones(4), mode="valid")
    return int(np.argmax(starts)) * block


def without_line(values: Floats) -> Floats:
    """Values without their mean and slope."""
    index = np.arange(len(values)) - (len(values) - 1) / 2.0
    slope = float(index @ values) / max(float(index @ index), 1.0)
    centred: Floats = values - values.mean() - slope * index
    return centred
