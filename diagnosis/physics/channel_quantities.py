"""Which quantities a channel shows beside the arm's motion: where none of them differs, a motion shows the same."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.physics.declared_effects import own_names
from stillarm.diagnosis.physics.space import Added, Space

_OWN: dict[str, tuple[tuple[str, ...], frozenset[str]]] = {
    "deflection": (("pair.offset",), frozenset()),
    "acceleration": (("accelerometer.",), own_names("sensitivity", "reading")),
    "displacement": (("camera.", "timing."), own_names("image")),
    "arrival": (("timing.",), frozenset()),
}
"""By channel: how the quantities' names begin, and further names."""


def own_places(channel: str, space: Space, added: Sequence[Added]) -> NDArray[np.int64]:
    """Places of a channel's own quantities in the vector; the amounts of terms that are added to it among them."""
    prefixes, names = _OWN.get(channel, ((), frozenset()))
    amounts = {one for group in added if channel in group.columns for one in group.amounts}
    own = [at for name, at in space.place.items() if name.startswith(prefixes) or name in names | amounts]
    return np.array(own, dtype=np.int64)
