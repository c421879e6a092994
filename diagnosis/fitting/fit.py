"""Maximum likelihood in free run: Gauss-Newton with derivatives by differences, noise levels learnt on the way."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import (
    HUBER,
    LEAST,
    InstantUncertainty,
    doubt_colour,
    level,
    likeliest_level,
    log_likelihood,
    wander_colour,
)
from stillarm.diagnosis.fitting.fitted import THIN, Colours, Data, Fit, least_level, thinned, thinned_mask
from stillarm.diagnosis.physics.computing import side_by_side
from stillarm.diagnosis.physics.world import Predicted, World

Array = NDArray[np.float64]
Slopes = Mapping[str, Mapping[str, Array]]
"""Derivatives of a fit by its free quantities and channels (`slopes_of`)."""

WANDER_S = 15.0
"""Longest correlation time of a delay's wander: what lasts longer is a drift, s."""
SETTLED_NATS = 0.02
"""A step of a fit that gains less is its last, unless the caller says otherwise."""

_FEW = 97  # of a column's values are looked at first
_PARTS = 4  # of the columns, which threads take one by one: two each, as some columns take longer
_DAMPING, _DAMPED = 1e-4, 6  # at the start; steps tried with ever more of it

CHANGED_NATS = 20.0
"""By so much another structure, of a baseline that is not in question, has to be likelier."""


def whitened(name: str, values: Array, colour: Colours) -> Array:
    """A channel's values, such as a change of its prediction, as a fit weighs them: whitened by its colour, thinned."""
    return thinned(name, colour[name].whiten(values) if name in colour else values)


def residuals_of(world: World, predicted: Predicted, vector: Array, colour: Colours) -> dict[str, Array]:
    """Measured less predicted, whitened where a channel has colour."""
    found = {}
    for name in world.channels:
        residual = world.residual(name, predicted, vector)
        found[name] = colour[name].whiten(residual) if name in colour else residual
    return found


def _levels(data: Data, residuals: dict[str, Array]) -> dict[str, float]:
    found = {}
    for name, residual in residuals.items():
        mask = data.train[name]
        found[name] = level(residual[mask], least_level(data.world, name))
    return found


def _likeliest_levels(data: Data, residuals: dict[str, Array]) -> dict[str, float]:
    """Noise levels at which the channels are likeliest, which a descent goes by: at the robust ones of `_levels` a step
    that lowers a large residual of one part may make the whole less likely."""
    found = {}
    for name, residual in residuals.items():
        trained, least = residual[data.train[name]], least_level(data.world, name)
        found[name] = likeliest_level(trained, level(trained, least), least)
    return found


def _nats(data: Data, residuals: dict[str, Array], sigma: dict[str, float]) -> tuple[Array, Array]:
    """Log-likelihood of each block: of what trains, and of what is held out."""
    train, held = np.zeros(len(data.split.held)), np.zeros(len(data.split.held))
    for name, residual in residuals.items():
        level_now = sigma[name]
        one = log_likelihood(residual / level_now, level_now)
        block, trained, judged = data.blocks[name], data.train[name], data.held[name]
        train += np.bincount(block[trained], one[trained], len(train))
        held += np.bincount(block[judged], one[judged], len(held))
    return train, held


def jacobian(
    world: World,
    vector: Array,
    names: Sequence[str],
    base: Predicted,
    colour: Colours,
    known: Slopes | None = None,
    before: dict[str, Array] | None = None,
) -> dict[str, Array]:
    """Derivative of each channel's (whitened, thinned) prediction by each named quantity, (samples, names). known:
    derivatives by quantity and channel that are taken as they are. before: those of a step before with the same names,
    which are overwritten but for the known ones."""
    steps = []
    for name in names:
        quantity, at = world.space[name], world.space.place[name]
        step = quantity.step
        if vector[at] + step > quantity.high:
            step = -step
        moved = vector.copy()
        moved[at] += step
        steps.append((moved, step))
    found = before or {
        name: np.empty((len(values) // THIN.get(name, 1), len(names)), order="F")
        for name, values in world.channels.items()
    }

    def by_difference(moved: Array, step: float) -> dict[str, Array]:
        """Of the channels that change."""
        predicted = world.predict(moved, base).channels
        changed = [channel for channel in found if predicted[channel] is not base.channels[channel]]
        with np.errstate(over="ignore", invalid="ignore"):  # of a trial in which the arm runs away
            return {channel: (predicted[channel] - base.channels[channel]) / step for channel in changed}

    def column(index: int) -> None:
        ready = known.get(names[index]) if known is not None else None
        if ready is not None:
            for channel, columns in found.items():
                columns[:, index] = ready[channel]
            return
        slopes = world.slopes_of_amount(names[index])
        if slopes is None:
            slopes = world.slopes_of_jump(names[index], vector, base)
        if slopes is None:
            slopes = by_difference(*steps[index])
        for channel, columns in found.items():
            columns[:, index] = whitened(channel, slopes[channel], colour) if channel in slopes else 0.0

    def columns_of(part: Sequence[int]) -> None:
        for index in part:
            column(index)

    there = known if known is not None and before is not None else {}
    asked = [index for index, name in enumerate(names) if name not in there]
    # a column may take less than it takes to hand it to another thread
    side_by_side(columns_of, [asked[first::_PARTS] for first in range(min(_PARTS, len(asked)))])
    return found


def colours(data: Data, vector: Array) -> Colours:
    """Colour of what the delay's law makes of the residuals: arrivals in freerun, images of a triggered camera, dated
    by arrivals, or by requests that are noted to the cycle."""
    world = data.world
    predicted = world.predict(vector)
    found: Colours = {}
    off = {name: values - predicted.channels[name] for name, values in world.channels.items()}
    arrivals, images = off.get("arrival"), off.get("displacement")
    if arrivals is not None:
        frames = WANDER_S / world.step_s("arrival")
        most = world.model.timing.capture_delay_std_s or inf  # a delay that wanders further is no usual one
        found["arrival"] = wander_colour(arrivals[data.trained("arrival")], frames, most)
    if images is not None and world.frame_clock.arrival:
        found["displacement"] = doubt_colour(
            images,
            predicted.rate_px_s,
            world.measured.frames.received_s,
            max(world.model.camera.noise_std_px, LEAST["displacement"]),
            world.model.timing.capture_delay_std_s,
        )
    if images is not None and world.measured.frames.asked:
        noise_px = max(world.model.camera.noise_std_px, LEAST["displacement"])
        noted_s = world.measured.cycle_s / sqrt(12.0)
        found["displacement"] = InstantUncertainty(
            predicted.rate_px_s, world.measured.frames.received_s, noise_px, noted_s, 0.0, 1.0
        )
    return found


@dataclass(frozen=True)
class _Point:
    """A vector, and what it makes of the recording. sigma: the likeliest noise levels; cost: less the log-likelihood at
    them, with the quantities' prior."""

    vector: Array
    predicted: Predicted
    residuals: dict[str, Array]
    sigma: dict[str, float]
    cost: float


class _Descent:
    """What stays the same while a fit goes on: the data, the free quantities, their prior, the channels' colour."""

    def __init__(self, data: Data, free: tuple[str, ...], colour: Colours, prior: Array | None) -> None:
        space = data.world.space
        self._data, self._colour, self._space = data, colour, space
        self.places = np.array([space.place[name] for name in free], dtype=np.int64)
        stds = np.array([space[name].prior_std for name in free])
        self.precision = np.where(np.isfinite(stds), 1.0 / stds**2, 0.0)
        self._centre = (space.vector() if prior is None else prior)[self.places]

    def off(self, vector: Array) -> Array:
        """By how much the free quantities are off their prior's middle."""
        off: Array = vector[self.places] - self._centre
        return off

    def point(self, vector: Array) -> _Point | None:
        """The recording at a vector; None where its simulation runs away."""
        predicted = self._data.world.predict(vector)
        finite = all(np.isfinite(one).all() for one in predicted.channels.values())
        return self._scored(vector, predicted) if finite else None

    def begun(self, vector: Array) -> _Point:
        """The recording at a vector, whatever it comes to."""
        return self._scored(vector, self._data.world.predict(vector))

    def _scored(self, vector: Array, predicted: Predicted) -> _Point:
        residuals = residuals_of(self._data.world, predicted, vector, self._colour)
        sigma = _likeliest_levels(self._data, residuals)
        nats = float(_nats(self._data, residuals, sigma)[0].sum())
        cost = -nats + float(0.5 * np.sum(self.precision * self.off(vector) ** 2))
        return _Point(vector, predicted, residuals, sigma, cost)

    def normal_equations(self, now: _Point, slopes: dict[str, Array]) -> tuple[Array, Array]:
        """Of a Gauss-Newton step from a point, outliers weighed down (Huber): matrix and right-hand side."""
        normal, right = np.diag(self.precision), -self.precision * self.off(now.vector)
        for name, slope in slopes.items():
            mask = thinned_mask(name, self._data.train[name])
            spread = now.sigma[name] / THIN.get(name, 1) ** 0.5
            residual = thinned(name, now.residuals[name])[mask]
            size = np.abs(residual) / spread
            weight = np.sqrt(np.minimum(1.0, HUBER / np.maximum(size, 1e-12))) / spread
            seen = _not_zero(slope)
            weighted = np.empty((len(residual), len(seen)), order="F")
            rows = np.flatnonzero(mask)
            for place, column in enumerate(seen):
                np.multiply(slope[:, column].take(rows), weight, out=weighted[:, place])
            normal[np.ix_(seen, seen)] += weighted.T @ weighted
            right[seen] += weighted.T @ (residual * weight)
        return normal, right

    def stepped(
        self, now: _Point, normal: Array, right: Array, damping: float
    ) -> tuple[_Point | None, float]:
        """The first of some ever more damped steps that lowers the cost (Levenberg 1944, Marquardt 1963), None where
        none does; and the damping that it took."""
        scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
        scaled, size = normal / np.outer(scale, scale), len(scale)
        for _ in range(_DAMPED):
            step = np.linalg.solve(scaled + damping * np.eye(size), right / scale) / scale
            moved = now.vector.copy()
            moved[self.places] += step
            moved = self._space.clipped(moved)
            # not so from a start so far off that its slopes overflow
            there = self.point(moved) if np.isfinite(moved).all() else None
            if there is not None and there.cost < now.cost:
                return there, damping
            damping = max(10.0 * damping, 1e-3)
        return None, damping


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of a trial in which the arm runs away
def fit(
    data: Data,
    start: Array,
    free: Sequence[str],
    *,
    iterations: int = 12,
    colour: Colours | None = None,
    prior: Array | None = None,
    tick: Callable[[], None] = lambda: None,
    known: Slopes | None = None,
    settled_nats: float = SETTLED_NATS,
    anew: int | None = None,
) -> Fit:
    """Fit the free quantities to the training samples from `start`, until a step gains less than settled_nats.

    anew: steps that work out the derivatives; later ones take the last (the chord method), None: all do.

    known: derivatives of a fit nearby (`slopes_of`), which are not worked out anew (the chord method): a step is then a
    little less good, and costs what the other quantities do.

    prior: vector about which the quantities' prior deviations count (default: the space's own start values).
    """
    world, free = data.world, tuple(free)
    vector = world.space.clipped(start)
    colour = colours(data, vector) if colour is None else colour
    descent = _Descent(data, free, colour, prior)
    now, damping = descent.begun(vector), _DAMPING
    normal, slopes = np.zeros((len(free), len(free))), None
    for step in range(iterations if free else 0):
        if slopes is None or anew is None or step < anew:
            slopes = jacobian(world, now.vector, free, now.predicted, colour, known, slopes)
        normal, right = descent.normal_equations(now, slopes)
        if not (np.isfinite(normal).all() and np.isfinite(right).all()):
            normal = np.diag(descent.precision)  # nothing is known of any: its deviations say so
            break
        there, damping = descent.stepped(now, normal, right, damping)
        tick()
        if there is None:
            break
        gained, now, damping = now.cost - there.cost, there, max(damping / 10.0, 1e-9)
        if gained < settled_nats:
            break
    covariance = _covariance(normal)
    std = {name: sqrt(max(covariance[i, i], 0.0)) for i, name in enumerate(free)}
    sigma = _levels(data, now.residuals)
    train, held = _nats(data, now.residuals, now.sigma)
    return Fit(
        world, now.vector, free, std, sigma, colour, now.residuals, now.predicted, float(train.sum()), held, train,
        covariance,
    )  # fmt: skip


def _not_zero(slope: Array) -> NDArray[np.int64]:
    """Places of the quantities that a channel shows at all: an impact on the arm is none of the joint's."""
    seen = np.asarray(slope[::_FEW].any(axis=0))
    for i in np.flatnonzero(~seen):
        seen[i] = slope[:, i].any()
    return np.flatnonzero(seen)


def slopes_of(last: Fit) -> dict[str, dict[str, Array]]:
    """Derivatives of a fit by its free quantities and channels, for fits nearby."""
    found = jacobian(last.world, last.vector, last.free, last.predicted, last.colour)
    return {
        name: {channel: columns[:, i] for channel, columns in found.items()}
        for i, name in enumerate(last.free)
    }


def _covariance(normal: Array) -> Array:
    if not normal.size:
        return normal
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    result: Array = inverse / np.outer(scale, scale)
    return result
