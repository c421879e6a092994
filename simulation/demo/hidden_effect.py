"""`demo --hide`: a cause that only the rig knows, and moves that reveal it."""

from math import isnan

import numpy as np

from stillarm.common.causes import CAUSES, Parameter, Value
from stillarm.common.files.scenario import Move

SHORTEST_S = 30.0
_STREAM = 0x41DE
_ONSET_SHARE = (0.3, 0.7)  # of the run: enough is left to either side
_DIGITS = 4
_BLOCK_S = 5.0
_SLOW_RAD_S, _FAST_RAD_S = 0.03, 0.2


def draw_effect(seed: int, duration_s: float) -> dict[str, Value]:
    """Cause, size, sign and onset from a seed, within what the catalogue calls typical; an [[effects]] entry.

    A clock that steps is the camera's: a live rig cannot step the controller's.
    """
    random = np.random.default_rng((seed, _STREAM))
    cause = CAUSES[str(random.choice(list(CAUSES)))]
    effect: dict[str, Value] = {"cause": cause.identifier}
    for parameter in cause.parameters:
        effect[parameter.name] = _draw(parameter, duration_s, random)
    return effect


def _draw(parameter: Parameter, duration_s: float, random: np.random.Generator) -> Value:
    if parameter.kind == "truth":
        return bool(random.random() < 0.5)
    if parameter.kind == "text":
        return "camera"
    if parameter.name == "onset_s":
        return round(duration_s * float(random.uniform(*_ONSET_SHARE)), 3)
    low, high = parameter.typical
    if parameter.kind == "whole":
        return int(random.integers(int(low), int(high) + 1))
    size = float(random.uniform(low, high) if low <= 0.0 else np.exp(random.uniform(*np.log((low, high)))))
    if parameter.signed and random.random() < 0.5:
        size = -size
    return float(f"{size + (0.0 if isnan(parameter.neutral) else parameter.neutral):.{_DIGITS}g}")


def revealing_moves(from_s: float, to_s: float) -> list[Move]:
    """As many times as there is room for: slow to and fro (play, friction, dead band), then fast there and back.

    Every block ends where it began. The fast moves' ramps are long enough not to swing the arm by more than 3 cm.
    """
    moves: list[Move] = []
    for block in range(int((to_s - from_s) / _BLOCK_S)):
        begin = from_s + block * _BLOCK_S
        for number, sign in enumerate((1.0, -1.0, -1.0, 1.0)):
            at = begin + 0.4 * number
            moves.append(Move(round(at, 3), round(at + 0.4, 3), sign * _SLOW_RAD_S))
        for at, sign in ((begin + 2.0, 1.0), (begin + 3.5, -1.0)):
            moves.append(Move(round(at, 3), round(at + 1.0, 3), sign * _FAST_RAD_S, 0.3))
    return moves
