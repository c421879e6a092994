"""Maximum likelihood in free run: Gauss-Newton with derivatives by differences, noise levels learnt on the way."""

from collections.abc import Callable, Mapping, Sequence
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from stillarm.diagnosis.data.noise import (
    HUBER,
    LEAST,
    InstantUncertainty,
    doubt_colour,
    level,
    log_likelihood,
    wander_colour,
)
from stillarm.diagnosis.inference.fitted import (
    THIN,
    Colours,
    Data,
    Fit,
    least_level,
    thinned,
    thinned_mask,
)
from stillarm.diagnosis.physics.computing import side_by_side
from stillarm.diagnosis.physics.world import Predicted, World

Array = NDArray[np.float64]

WANDER_S = 15.0
_WANDERS = 2.0  # times the stated deviation: a delay that strays further is no wander of the usual one
SETTLED_NATS = 0.02
"""A step of a fit that gains less is its last, unless the caller says otherwise."""

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
    known: Mapping[str, Mapping[str, Array]] | None = None,
) -> dict[str, Array]:
    """Derivative of each channel's (whitened, thinned) prediction by each named quantity, (samples, names). known:
    derivatives by quantity and channel that are taken as they are."""
    steps = []
    for name in names:
        quantity, at = world.space[name], world.space.place[name]
        step = quantity.step
        if vector[at] + step > quantity.high:
            step = -step
        moved = vector.copy()
        moved[at] += step
        steps.append((moved, step))
    found = {
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
            slopes = by_difference(*steps[index])
        for channel, columns in found.items():
            columns[:, index] = whitened(channel, slopes[channel], colour) if channel in slopes else 0.0

    side_by_side(column, range(len(names)))
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
        most = _WANDERS * world.model.timing.capture_delay_std_s or inf
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


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of a trial in which the arm runs away
def fit(  # noqa: PLR0915  (one loop over what belongs together)
    data: Data,
    start: Array,
    free: Sequence[str],
    *,
    iterations: int = 12,
    colour: Colours | None = None,
    prior: Array | None = None,
    tick: Callable[[], None] = lambda: None,
    known: Mapping[str, Mapping[str, Array]] | None = None,
    settled_nats: float = SETTLED_NATS,
) -> Fit:
    """Fit the free quantities to the training samples from `start`, until a step gains less than settled_nats.

    known: derivatives of a fit nearby (`slopes_of`), which are not worked out anew (the chord method): a step is then a
    little less good, and costs what the other quantities do.

    prior: vector about which the quantities' prior deviations count (default: the space's own start values).
    """
    world = data.world
    space = world.space
    free = tuple(free)
    places = np.array([space.place[name] for name in free], dtype=np.int64)
    prior_std = np.array([space[name].prior_std for name in free])
    centre = (space.vector() if prior is None else prior)[places]
    precision = np.where(np.isfinite(prior_std), 1.0 / prior_std**2, 0.0)
    vector = space.clipped(start)
    if colour is None:
        colour = colours(data, vector)
    predicted = world.predict(vector)
    residuals = residuals_of(world, predicted, vector, colour)
    sigma = _levels(data, residuals)
    train, held = _nats(data, residuals, sigma)

    def penalty(candidate: Array) -> float:
        return float(0.5 * np.sum(precision * (candidate[places] - centre) ** 2))

    cost = -float(train.sum()) + penalty(vector)
    normal = np.zeros((len(free), len(free)))
    damping = 1e-4
    for _ in range(iterations):
        if not free:
            break
        slopes = jacobian(world, vector, free, predicted, colour, known)
        normal = np.zeros((len(free), len(free)))
        right = np.zeros(len(free))
        for name, slope in slopes.items():
            mask = thinned_mask(name, data.train[name])
            spread = sigma[name] / THIN.get(name, 1) ** 0.5
            residual = thinned(name, residuals[name])[mask]
            size = np.abs(residual) / spread
            weight = np.sqrt(np.minimum(1.0, HUBER / np.maximum(size, 1e-12))) / spread
            weighted = slope[mask] * weight[:, None]
            normal += weighted.T @ weighted
            right += weighted.T @ (residual * weight)
        right -= precision * (vector[places] - centre)
        normal += np.diag(precision)
        if not (np.isfinite(normal).all() and np.isfinite(right).all()):
            normal = np.diag(precision)  # nothing is known of any: its deviations say so
            break
        scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
        scaled = normal / np.outer(scale, scale)
        improved = False
        for _ in range(6):
            step = np.linalg.solve(scaled + damping * np.eye(len(free)), right / scale) / scale
            moved = vector.copy()
            moved[places] += step
            moved = space.clipped(moved)
            if not np.isfinite(moved).all():  # a start so far off that its slopes overflow
                damping = max(10.0 * damping, 1e-3)
                continue
            new_predicted = world.predict(moved)
            new_residuals = residuals_of(world, new_predicted, moved, colour)
            if all(np.isfinite(new_predicted.channels[c]).all() for c in new_predicted.channels):
                new_sigma = _levels(data, new_residuals)
                new_train, new_held = _nats(data, new_residuals, new_sigma)
                new_cost = -float(new_train.sum()) + penalty(moved)
                if new_cost < cost:
                    improved = True
                    break
            damping = max(10.0 * damping, 1e-3)
        tick()
        if not improved:
            break
        gained = cost - new_cost
        vector, predicted, residuals = moved, new_predicted, new_residuals
        sigma, train, held, cost = new_sigma, new_train, new_held, new_cost
        damping = max(damping / 10.0, 1e-9)
        if gained < settled_nats:
            break
    covariance = _covariance(normal)
    std = {name: sqrt(max(covariance[i, i], 0.0)) for i, name in enumerate(free)}
    return Fit(
        world, vector, free, std, sigma, colour, residuals, predicted, float(train.sum()), held, train,
    )  # fmt: skip


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
