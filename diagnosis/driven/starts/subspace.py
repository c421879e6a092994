"""Modes from a subspace fit of input and outputs: where the fit of a grey box begins.

A search over frequencies one by one misses a lightly damped arm between two of them. The poles of a state space need no
start: PO-MOESP (Verhaegen, Automatica 30, 1994) takes them from the row space of past and future data. Poles of the
whole are those of the arm on its free hub, zeros from the input to the joint those of the arm whose hub is held:

    1 + sum_i c_i w_i^2 / (s^2 + w_i^2) = prod_j (s^2 + W_j^2) / (s^2 + w_j^2)

so that poles W and zeros w tell the inertia c_i that each mode carries, over the hub's.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.driven.recording.signals import Driven

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_ROWS = 20  # of blocks of past and of future data: several times the largest order
_FEWEST = 400  # samples
_MOST = 12_000  # samples: more make it slow, and no better a start
_SLOWEST_HZ = 8.0  # to which a recording is thinned: four samples a period of a slow arm
_THINNER = 2.5  # from one rate to the next
_STABLE = 0.99999  # of a pole's size: one that noise brings outside is put back
# a hub's own damping makes a pole's larger than the arm's
_LEAST_ZETA, _LIKELY_ZETA, _MOST_ZETA = 1e-3, 0.03, 0.3
_LEAST_CARRIED, _MOST_CARRIED = 0.01, 20.0  # inertia of a mode over the hub's: between them a fit begins
_USUAL_CARRIED = 0.2  # where no zero shows


@dataclass(frozen=True)
class SeenMode:
    """A mode of the arm whose hub is held: w rad/s, damping ratio, inertia over the hub's."""

    w: float
    zeta: float
    carries: float


def modes_seen(driven: Driven, count: int) -> Iterator[tuple[SeenMode, ...]]:
    """Sets of `count` modes, ascending, each from the recording at another rate or from a state of another order."""
    part = (
        driven if not driven.joins else max((driven.part(k) for k in range(driven.recordings)), key=_length)
    )
    thinner = 1.0
    while thinner == 1.0 or 1.0 / (thinner * part.step_s) >= _SLOWEST_HZ:
        every = round(thinner)
        u, outputs, joint = _signals(part, every)
        if len(u) < _FEWEST:
            break
        for order in (1 + 2 * count, 3 + 2 * count):  # noise asks for a pole of its own now and then
            found = _modes(_poles(u, outputs, order), u, outputs, joint, every * part.step_s)
            yield from combinations(found, count)
        thinner *= _THINNER


def _length(driven: Driven) -> int:
    return driven.samples


def _signals(driven: Driven, every: int) -> tuple[Array, list[Array], int | None]:
    """Input and outputs over their deviation, averaged over `every` samples; which output is the joint's velocity.

    An angle is told by its differences, so that its drift does not hide the arm.
    """
    most = min(driven.samples, _MOST * every) // every * every
    outputs: list[Array] = []
    joint: int | None = None
    for kind in ("velocity", "position", "motor", "deflection", "acceleration"):
        for one in driven.outputs:
            if one.kind != kind:
                continue
            known = np.isfinite(one.values)
            values = np.interp(np.arange(driven.samples), np.flatnonzero(known), one.values[known])[:most]
            values = values.reshape(-1, every).mean(axis=1)
            values = np.diff(values) if kind in ("position", "motor") else values[1:]
            joint = len(outputs) if joint is None and kind in ("velocity", "position", "motor") else joint
            outputs.append((values - values.mean()) / max(float(values.std()), 1e-300))
    u = driven.u[:most].reshape(-1, every).mean(axis=1)[1:]
    return (u - u.mean()) / max(float(u.std()), 1e-300), outputs, joint


def _poles(u: Array, outputs: list[Array], order: int) -> Complex:
    """Eigenvalues of the state's transition over a sample, by PO-MOESP of the given order."""
    rows, y = _ROWS, np.array(outputs)
    columns = len(u) - 2 * rows + 1
    past_u, next_u = (_hankel(u[None], begin, rows, columns) for begin in (0, rows))
    past_y, next_y = (_hankel(y, begin, rows, columns) for begin in (0, rows))
    stack = np.vstack([next_u, past_u, past_y, next_y])
    lower = np.asarray(np.linalg.qr(stack.T, mode="r")).T
    a, b = len(next_u), len(next_u) + len(past_u) + len(past_y)
    left, _, _ = np.linalg.svd(lower[b:, a:b], full_matrices=False)
    seen = left[:, :order]
    shifted = np.linalg.lstsq(seen[: -len(y)], seen[len(y) :], rcond=None)[0]
    return np.asarray(np.linalg.eigvals(shifted), np.complex128)


def _hankel(y: Array, begin: int, rows: int, columns: int) -> Array:
    return np.vstack([y[:, begin + r : begin + r + columns] for r in range(rows)])


def _modes(
    poles: Complex, u: Array, outputs: list[Array], joint: int | None, step_s: float
) -> tuple[SeenMode, ...]:
    size = np.abs(poles)
    poles = np.where(size > _STABLE, poles / size * _STABLE, poles)
    free = _ringing(poles, step_s)
    held = [] if joint is None else _ringing(_zeros(poles, u, outputs[joint]), step_s)
    pairs, below = [], 0.0
    for w, zeta in free:  # between two poles there is one zero
        between = [one for one in held if below < one[0] < w]
        held_w, own = between[-1] if between else (w / np.sqrt(1.0 + _USUAL_CARRIED), zeta)
        pairs.append((float(held_w), float(min(own, zeta, _LIKELY_ZETA)), w))
        below = w
    found = []
    for i, (w, zeta, _) in enumerate(pairs):
        carried = np.prod([each[2] ** 2 / w**2 - 1.0 for each in pairs]) / np.prod(
            [each[0] ** 2 / w**2 - 1.0 for k, each in enumerate(pairs) if k != i]
        )
        found.append(SeenMode(w, zeta, min(max(float(carried), _LEAST_CARRIED), _MOST_CARRIED)))
    return tuple(found)


def _ringing(roots: Complex, step_s: float) -> list[tuple[float, float]]:
    """Angular frequency and damping ratio of the roots that ring, ascending."""
    s = np.log(np.where(roots == 0.0, 1e-12, roots)) / step_s
    found = [(float(abs(one)), float(-one.real / abs(one))) for one in s if one.imag > 0.0]
    return sorted(
        (w, min(max(zeta, _LEAST_ZETA), _MOST_ZETA))
        for w, zeta in found
        if abs(zeta) < 2.0 * _MOST_ZETA and w < 0.98 * np.pi / step_s
    )


def _zeros(poles: Complex, u: Array, output: Array) -> Complex:
    """Zeros from input to an output, whose residues at the poles are regressed."""
    k = np.arange(len(u))
    columns = [u.astype(np.complex128)]
    columns += [lfilter([0.0, 1.0], [1.0, -one], u.astype(np.complex128)) for one in poles]
    columns += [one**k for one in poles]
    residues = np.linalg.lstsq(np.array(columns).T, output.astype(np.complex128), rcond=None)[0]
    numerator = residues[0] * np.poly(poles)
    for i, one in enumerate(residues[1 : 1 + len(poles)]):
        numerator[1:] += one * np.poly(np.delete(poles, i))
    return np.asarray(np.roots(numerator), np.complex128)
