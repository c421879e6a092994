"""The vector of everything the simulation can be told: the model's parameters, initial states, causes' parameters.

Terms without a formula of their own are columns that are added to what channels should show, in amounts that are
quantities of the vector, too. A course over time (a bias, an image zero, a gain) is a sum of hat functions.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """One place of the vector.

    start: value where nothing is known better. low, high: bounds of a fit. step: for a derivative by differences.
    prior_std: how far it may lie from start before that counts against it (inf: anywhere).
    """

    name: str
    start: float
    low: float = -inf
    high: float = inf
    step: float = 1e-6
    prior_std: float = inf


@dataclass
class Space:
    """Quantities by name and place."""

    quantities: list[Quantity] = field(default_factory=list)
    place: dict[str, int] = field(default_factory=dict)

    def add(self, quantity: Quantity) -> None:
        """One more place."""
        self.place[quantity.name] = len(self.quantities)
        self.quantities.append(quantity)

    def vector(self) -> Array:
        """Start values."""
        return np.array([quantity.start for quantity in self.quantities])

    def with_values(self, vector: Array, values: Mapping[str, float]) -> Array:
        """A copy of a vector with other values at some places."""
        found = vector.copy()
        for name, value in values.items():
            found[self.place[name]] = value
        return found

    def names(self, prefix: str | tuple[str, ...]) -> list[str]:
        """All names that begin so, or so."""
        return [quantity.name for quantity in self.quantities if quantity.name.startswith(prefix)]

    def __getitem__(self, name: str) -> Quantity:
        return self.quantities[self.place[name]]

    def within_bounds(self, name: str, vector: Array) -> bool:
        """Whether a quantity may move both ways."""
        quantity, value = self[name], float(vector[self.place[name]])
        return quantity.low < value < quantity.high

    def clipped(self, vector: Array) -> Array:
        """Within all bounds."""
        low = np.array([quantity.low for quantity in self.quantities])
        high = np.array([quantity.high for quantity in self.quantities])
        return np.clip(vector, low, high)


@dataclass(frozen=True, eq=False)
class Added:
    """One group of terms. columns: by channel, (samples, amounts). prior_std: of each amount. over_time: a course, of
    which samples tell what lies between them alone; walks: one that a law found to be the whole of what was left. hz:
    of waves, if they are."""

    name: str
    columns: Mapping[str, Array]
    prior_std: float
    over_time: bool = False
    hz: float = 0.0
    walks: bool = False

    @property
    def amounts(self) -> tuple[str, ...]:
        """The names of its quantities."""
        count = next(iter(self.columns.values())).shape[1]
        return tuple(f"{self.name}.{i}" for i in range(count))


def hats(time_s: Array, knots_s: Array) -> Array:
    """Hat functions, (samples, knots): each 1 at its knot, falling to 0 at its neighbours."""
    found = np.empty((len(time_s), len(knots_s)))
    for i in range(len(knots_s)):
        one = np.zeros(len(knots_s))
        one[i] = 1.0
        found[:, i] = np.interp(time_s, knots_s, one)
    return found
