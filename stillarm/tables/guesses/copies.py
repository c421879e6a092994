"""Which column is another one in other units: y = scale * x + offset, by least squares."""

from dataclasses import dataclass

import numpy as np

from stillarm.tables.guesses.spectra import Floats, Spectra

EXACT = 2e-3  # rms of the rest, of the column's own std: rounding
NEAR = 0.15  # of the same: two sensors of one thing


@dataclass(frozen=True)
class Copy:
    """column = scale * of + offset; rest: rms of what remains, as a share of the column's std."""

    column: str
    of: str
    scale: float
    offset: float
    rest: float


def copies(spectra: Spectra) -> list[Copy]:
    """Each column that repeats an earlier one, exactly but for rounding, or nearly (rest above EXACT): the closest."""
    found: list[Copy] = []
    names = list(spectra.samples)
    for index, name in enumerate(names):
        options = [
            compared(name, spectra.samples[name], other, spectra.samples[other]) for other in names[:index]
        ]
        sure = [copy for copy in options if copy is not None and copy.rest < NEAR]
        if sure:
            exact = [copy for copy in sure if copy.rest < EXACT]
            found.append(exact[0] if exact else min(sure, key=lambda copy: copy.rest))
    return found


def compared(name: str, values: Floats, other: str, reference: Floats) -> Copy | None:
    """The line through one column over another; None where one of them is constant."""
    y, x = values - values.mean(), reference - reference.mean()
    size_x, size_y = float(x @ x), float(y @ y)
    if size_x <= 0.0 or size_y <= 0.0:
        return None
    scale = float(x @ y) / size_x
    rest = float(np.sqrt(max(0.0, 1.0 - (float(x @ y) ** 2) / (size_x * size_y))))
    return Copy(name, other, scale, float(values.mean() - scale * reference.mean()), rest)
