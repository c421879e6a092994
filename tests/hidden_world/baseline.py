"""What any honest analyst may refit before naming a cause, and what it does to the measured channels.

Initial state, jump of the bends' rates at each impact, frequency, damping and share of each bend, image scale and
offset, accelerometer bias, mean delay, and where the exposures lie in time.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.motion import WIDTH
from tests.hidden_world.rig import Bend, Rig
from tests.hidden_world.whitened import whitened
from tests.hidden_world.world import Case, Moved, Open, moved, sensed

Array = NDArray[np.float64]
Change = Callable[[Rig, float], Rig]


@dataclass(frozen=True)
class Freedom:
    """One number that is refitted: `step` is small against what matters, and is the unit that it is counted in."""

    name: str
    step: float
    change: Change | None = None
    moves: bool = False
    """Whether the arm moves differently, or is only seen differently."""
    state: int = -1
    impact: int = -1


def freedoms(case: Case, impacts: int) -> list[Freedom]:
    """All of them, for a case without effects."""
    rig = case.rig
    out = [
        Freedom(
            "px_per_m", 1e-4, lambda r, x: replace(r, eye=replace(r.eye, px_per_m=r.eye.px_per_m * (1.0 + x)))
        ),
        Freedom(
            "centre_px", 0.01, lambda r, x: replace(r, eye=replace(r.eye, centre_px=r.eye.centre_px + x))
        ),
        Freedom("bias", 0.001, lambda r, x: replace(r, feeler=replace(r.feeler, bias=r.feeler.bias + x))),
        Freedom("late_s", 1e-5, lambda r, x: replace(r, eye=replace(r.eye, late_s=r.eye.late_s + x))),
        Freedom("phase_s", 1e-5, lambda r, x: replace(r, eye=replace(r.eye, phase_s=r.eye.phase_s + x))),
        Freedom("start_angle", 1e-4, state=0),
        Freedom("start_speed", 1e-4, state=1),
    ]
    if rig.eye.stamped:
        out += [
            Freedom(
                "stamp_s",
                1e-6,
                lambda r, x: replace(r, eye=replace(r.eye, stamp_offset_s=r.eye.stamp_offset_s + x)),
            ),
            Freedom(
                "stamp_ppm", 0.01, lambda r, x: replace(r, eye=replace(r.eye, stamp_ppm=r.eye.stamp_ppm + x))
            ),
        ]
    for order in range(len(rig.bends)):
        out += [
            Freedom(
                f"hertz_{order}",
                1e-6,
                _bend(order, lambda b, x: replace(b, hertz=b.hertz * (1.0 + x))),
                moves=True,
            ),
            Freedom(
                f"loss_{order}", 1e-6, _bend(order, lambda b, x: replace(b, loss=b.loss + x)), moves=True
            ),
            Freedom(
                f"share_{order}", 1e-5, _bend(order, lambda b, x: replace(b, share=b.share + x)), moves=True
            ),
            Freedom(f"start_bend_{order}", 1e-6, state=2 + 2 * order),
            Freedom(f"start_rate_{order}", 1e-5, state=3 + 2 * order),
        ]
    return out + [Freedom(f"blow_{k}", 1e-4, impact=k) for k in range(impacts)]


def _bend(order: int, change: Callable[[Bend, float], Bend]) -> Change:
    def changed(rig: Rig, x: float) -> Rig:
        bends = list(rig.bends)
        bends[order] = change(bends[order], x)
        return replace(rig, bends=tuple(bends))

    return changed


@dataclass
class Baseline:
    """The case without effects under one command, as a vector, and how it moves with each freedom."""

    case: Case
    command: Array
    free: list[Freedom]
    at: Array
    basis: Array
    """Orthonormal columns that span what the freedoms can do."""
    into: Array
    """basis @ into = the Jacobian, per step of each freedom."""

    def left(self, vector: Array) -> Array:
        """What of a difference no freedom can take up."""
        return np.asarray(vector - self.basis @ (self.basis.T @ vector))

    def absorbed(self, vector: Array) -> Array:
        """The steps of the freedoms that take up as much of a difference as they can."""
        solved = np.linalg.lstsq(self.into, self.basis.T @ vector, rcond=1e-9)[0]
        return np.asarray(solved)

    def moved(self, steps: Array) -> Array:
        """The vector with the freedoms moved by so many steps each, by simulation."""
        return vector_of(self, steps)


def vector_of(base: Baseline, steps: Array) -> Array:
    """The case's vector with the freedoms moved by so many steps each, by simulation."""
    return _vector(base.case, base.command, base.free, steps, None)


def baseline(case: Case, command: Array, impacts: int) -> Baseline:
    """Linearise the case without its effects, given the command that was recorded."""
    bare = replace(case, effects=())
    free = freedoms(bare, impacts)
    motion = moved(bare, Open(command=command))
    at = whitened(bare, sensed(bare, motion))
    columns = []
    for row, one in zip(np.eye(len(free)), free, strict=True):
        seen_only = one.change is not None and not one.moves
        columns.append(_vector(bare, command, free, row, motion if seen_only else None) - at)
    jacobian = np.stack(columns, axis=1)
    basis, into = np.linalg.qr(jacobian)
    return Baseline(bare, command, free, at, basis, into)


def _vector(bare: Case, command: Array, free: list[Freedom], steps: Array, motion: Moved | None) -> Array:
    """With the freedoms moved by so many steps. motion: where they leave it as it was."""
    rig, start = bare.rig, np.zeros(WIDTH)
    impacts = sum(f.impact >= 0 for f in free)
    impact = np.zeros(impacts)
    for one, steps_of_it in zip(free, steps.tolist(), strict=True):
        amount = one.step * steps_of_it
        if one.change is not None:
            rig = one.change(rig, amount)
        elif one.state >= 0:
            start[one.state] += amount
        else:
            impact[one.impact] += amount
    case = replace(bare, rig=rig)
    motion = motion or moved(case, Open(start=start, impact_change=impact, command=command))
    return whitened(case, sensed(case, motion))
