"""Higher modes that a fit has lost: begun again from where the model has them.

While something larger is unexplained, a payload that was put down in mid-run, say, a small mode is bent to make up for
it: its frequency goes elsewhere, and its share to nothing or to another sign. From there no slope leads back.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.fit import Fit, Split, fit, make_data
from stillarm.diagnosis.frequency_course import shares
from stillarm.diagnosis.quantities import HIGHER

Array = NDArray[np.float64]

_FAR, _LEAST, _MOST = 0.03, 0.5, 2.0  # of the model's frequency; of its participation
_SEEN = 0.2  # standard deviation of the participation, over the model's
_OFF = (1.0, 0.98, 1.02)  # of the model's frequency
_BETTER_NATS = 3.0


def lost_modes(one: Fit) -> list[int]:
    """The model's modes beyond the first that a fit has at another frequency, or with another share."""
    return [i for i in range(1, len(one.world.model.arm.modes)) if _is_lost(one, i)]


def _is_lost(one: Fit, mode: int) -> bool:
    """Not where the data hardly show the mode, so that its share is anything."""
    frequency, participation = f"modes.{mode}.frequency_hz", f"modes.{mode}.participation"
    space = one.world.space
    hz, whole = one.value(frequency) / space[frequency].start, space[participation].start or 1.0
    if one.std.get(participation, 0.0) > _SEEN * abs(whole):
        return False
    return abs(hz - 1.0) > _FAR or not _LEAST < one.value(participation) / whole < _MOST


def with_lost_modes(one: Fit, split: Split) -> Fit:
    """The fit, or a likelier one with its lost modes begun again."""
    for i in lost_modes(one):
        data = make_data(one.world, split)
        tried = [
            fit(
                data,
                one.world.space.with_values(_begun_again(one, i, off), others),
                one.free,
                colour=one.colour,
            )
            for off in _OFF
            for others in (shares(one.world) if HIGHER in one.free else ({},))
        ]
        best = max(tried, key=lambda other: other.train_log_likelihood)
        one = best if best.train_log_likelihood > one.train_log_likelihood + _BETTER_NATS else one
    return one


def _begun_again(one: Fit, mode: int, off: float) -> Array:
    """The fit's vector with that mode as the model has it, at rest, its frequency off by a factor."""
    space = one.world.space
    jumps = [name for name in space.names("jump.") if name.split(".")[2] == str(mode)]
    values = {name: space[name].start for name in (*space.names(f"modes.{mode}."), *jumps)}
    values[f"modes.{mode}.frequency_hz"] *= off
    return space.with_values(one.vector, values)
