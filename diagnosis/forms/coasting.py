"""Play in the gear, behind which the link coasts: where a search for it begins, from what the encoder saw.

Every touch decides where the next one is, so that a fit finds the law from nearby alone. But the link comes to rest
against both flanks sooner or later: the encoder's departure from the motor is as wide as the play. The rest is tried
over the first part of the recording, in which little has added up, and taken on over longer parts of it.
"""

from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data import robust
from stillarm.diagnosis.forms.cause import Cause, Context, Trial, driven, free_of, plain
from stillarm.diagnosis.physics.coasting_play import link_velocity
from stillarm.diagnosis.physics.computing import check_time
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.quantities import COASTING

Array = NDArray[np.float64]
_Values = tuple[float, ...]

_LEAST_OF_NOISE = 4.0
"""Of the encoder: a narrower departure, its noise aside, tells no course between two flanks."""
_WIDTH = 0.001  # of the samples are left out at each end of the departure, for its width
_OF_NOISE = 6.18  # deviations of normal noise between these ends
_AVERAGED = (4, 8)
"""Samples that are looked at as one: the teeth's course, 60 Hz as a rule, is told by means of four at 1 kHz; eight,
where the departure is as narrow as the noise of those."""
_GRID = (
    (0.85, 0.92, 1.0, 1.08, 1.2),
    (0.5, 2.0, 8.0, 30.0),  # drag, 1/s: beyond it the link stands, as the declared play has it
    (30.0, 60.0, 120.0),  # of the teeth, Hz: below are the arm's own, above they are hard
    (0.1, 0.3, 0.7),  # damping ratio of the teeth: from a bounce to none
)
"""First the gap over the width: teeth give way, no flank may have been touched at rest, and noise hides an end."""
_LEAST_OF_WIDTH = 0.5
"""Of a gap: the link comes to rest against both flanks. A narrower one imitates a late drive."""
_TEETH_HZ, _MOST_DAMPING = (25.0, 300.0), 2.0  # that a search goes to: softer teeth imitate a lag
_PARTS = (0.25, 0.5, 1.0)  # of the recording from its first departure on, one after another
_DEPARTED = 0.4  # of the width: four times the least noise of which it is told
_AT_REST = 0.0  # at the start, rad/s: without a play a fit makes up for the departure by another
_NO_PLAY = (1e-9, 0.0, 60.0, 0.3)  # gap, drag, teeth of a link that follows its motor
_FIRST_STEP, _LEAST_STEP = 0.2, 0.004  # of each value's logarithm, in a search along it
_NEAR = 0.03  # of the width, or the noise: what is nearer follows the course
_BEST = 3  # of the grid, that are searched on from
_NODES = 31  # of a mean over normal noise: to a thousandth
_FOLLOWED = 0.35
"""Of the cost without a play, their noise aside: what leaves more follows no course, and costs no more time. Plays of
foreign rigs left 0.0 to 0.2, what was none 0.5 and more."""
_MOST_TRIALS = 150  # of a search: four values, some ten steps each to either side


@dataclass(frozen=True)
class _Seen:
    """What the encoder saw. command: as it reaches the drive, rad/s; position: of the joint, rad; decay, most: of the
    drive, 1/s, rad/s^2; width: of the departure, rad; begins: part of the recording before it; averaged: samples that
    are looked at as one; noise: of these, rad; velocity: of the joint, rad/s, None where no noise of it is known."""

    command: Array
    position: Array
    cycle_s: float
    decay: float
    most: float
    width: float
    begins: float
    averaged: int
    noise: float
    velocity: Array | None
    velocity_noise: float

    @property
    def near(self) -> float:
        """What is nearer to a course follows it, rad."""
        return max(_NEAR * self.width, self.noise)

    @property
    def least(self) -> float:
        """Cost of the encoder's noise by itself."""
        at, weights = np.polynomial.hermite_e.hermegauss(_NODES)
        of_noise = np.log1p((self.noise / self.near * at) ** 2)
        if self.velocity is not None:
            of_noise = of_noise + np.log1p(at**2)
        return float(weights @ of_noise / weights.sum())

    def cost(self, values: _Values, part: float) -> float:
        """Nats a sample by which a course departs over a part of the recording, far departures all alike (Cauchy)."""
        check_time()
        n = round((self.begins + part * (1.0 - self.begins)) * len(self.command))
        reached = link_velocity(self.command[: n - 1], self.cycle_s, self.decay, self.most, _AT_REST, *values)
        rate = np.concatenate(([_AT_REST], reached))  # at the beginning of each cycle, when it is measured
        way = self.cycle_s * (np.cumsum(rate) - 0.5 * rate)
        off = _means(self.position[:n] - way, self.averaged)
        found = _departs((off - np.nanmedian(off)) / self.near)
        if self.velocity is not None:
            found += _departs(_means(self.velocity[:n] - rate, self.averaged) / self.velocity_noise)
        return found


def _seen(context: Context) -> _Seen | None:
    """None where the encoder saw nothing that a play could be."""
    fit, world = context.fit, context.world
    shown = fit.channel("joint_position")
    if shown is None or world.behind_encoder or context.value(COASTING[0]) > 0.0:
        return None
    # not as it is judged: of a fine encoder that grants a part of what a drive may be off
    departure = shown.measured - fit.predicted.motion.joint[:, 0]
    wide = next((one for one in map(partial(_wide, departure), _AVERAGED) if one is not None), None)
    if wide is None:
        return None
    averaged, width, noise = wide
    cycle_s, drive = world.measured.cycle_s, world.model.drive
    # without what the fit has of a command's arrival beyond that: a play of any width makes it later
    late = context.value("drive.dead_time_s") / cycle_s
    top = context.value("drive.max_velocity_rad_s")
    command = np.clip(np.nan_to_num(world.measured.command), -top, top)
    cycles = np.arange(len(command), dtype=np.float64)
    arrived = np.interp(cycles - late, cycles, command)
    decay = 2.0 * np.pi * context.value("drive.bandwidth_hz")
    most = drive.max_acceleration_rad_s2
    off = _means(departure, averaged)
    off = np.abs(off - off[np.isfinite(off)][0])
    begins = float(np.argmax(off > _DEPARTED * width + _OF_NOISE * noise)) / len(off)
    rate = fit.channel("joint_velocity")
    velocity_noise = robust.white_noise(_means(rate.measured, averaged)) if rate is not None else 0.0
    velocity = rate.measured if rate is not None and velocity_noise > 0.0 else None
    return _Seen(
        arrived,
        shown.measured,
        cycle_s,
        decay,
        most,
        width,
        begins,
        averaged,
        noise,
        velocity,
        velocity_noise,
    )


def _wide(departure: Array, averaged: int) -> tuple[int, float, float] | None:
    """How wide a departure is without its noise, and that noise, rad, in means of so many samples; None where it is too
    narrow."""
    means = _means(departure, averaged)
    noise = robust.white_noise(means)
    low, high = np.nanquantile(means, (_WIDTH, 1.0 - _WIDTH))
    width = float(high - low) - _OF_NOISE * noise
    return (averaged, width, noise) if width > _LEAST_OF_NOISE * noise else None


def _departs(off: Array) -> float:
    """Nats a sample by which values in units of their noise depart from zero, far ones all alike (Cauchy)."""
    return float(np.nanmean(np.log1p(off * off)))


def _means(values: Array, averaged: int) -> Array:
    """Means of so many samples each, of those that are known; NaN where none is."""
    count = len(values) // averaged
    some = values[: count * averaged].reshape(count, averaged)
    known = np.isfinite(some)
    total, number = np.where(known, some, 0.0).sum(axis=1), known.sum(axis=1)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _follows(seen: _Seen) -> _Values | None:
    """Gap, drag, teeth's frequency and damping whose course the encoder follows best; None where it follows none."""
    grid = [(gap * seen.width, *rest) for gap, *rest in product(*_GRID)]
    costs = shared_out(lambda one: seen.cost(one, _PARTS[0]), grid)
    tried = [one for _, one in sorted(zip(costs, grid, strict=True))[:_BEST]]
    for part in _PARTS:
        searched = sorted(shared_out(partial(_searched, seen, part=part), tried))
        if searched[0][0] - seen.least > _FOLLOWED * (seen.cost(_NO_PLAY, part) - seen.least):
            return None
        tried = [one for _, one in searched]
    return tried[0]


def _searched(seen: _Seen, values: _Values, part: float) -> tuple[float, _Values]:
    """The least cost along each value in turn, by halving steps of its logarithm."""
    step, cost, trials = _FIRST_STEP, seen.cost(values, part), 0
    while step > _LEAST_STEP and trials < _MOST_TRIALS:
        moved = False
        trials += 2 * len(values)
        for place, way in product(range(len(values)), (1.0, -1.0)):
            there = (*values[:place], values[place] * float(np.exp(way * step)), *values[place + 1 :])
            if not _possible(seen, there):
                continue
            now = seen.cost(there, part)
            if now < cost:
                values, cost, moved = there, now, True
        if not moved:
            step *= 0.5
    return cost, values


def _possible(seen: _Seen, values: _Values) -> bool:
    """Whether a search may go there."""
    gap, _, teeth_hz, damping = values
    softest, hardest = _TEETH_HZ
    return gap > _LEAST_OF_WIDTH * seen.width and softest < teeth_hz < hardest and damping < _MOST_DAMPING


def _trials(context: Context) -> list[Trial]:
    seen = _seen(context)
    values = _follows(seen) if seen is not None else None
    if values is None:
        return []
    gap, *rest = values
    shape = {"start.omega": _AT_REST} | dict(zip(COASTING[1:], rest, strict=True))
    return [Trial(shape, ({COASTING[0]: gap},), one_sided=True, exact=True)]


CAUSE = Cause(
    id="gear_backlash",
    needs=driven,
    trials=_trials,
    free=free_of(*COASTING),
    parameters_of=lambda fit: plain(fit, gap_rad=COASTING[0]),
)
