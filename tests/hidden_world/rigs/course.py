"""How a thing changes over time: the courses that drifts take. Each is 0 until its onset and about 1 at the end."""

from collections.abc import Callable

import numpy as np

from tests.hidden_world.rigs.rig import Values


def course(form: str, time_s: Values, onset_s: float, seed: int, path: Values | None = None) -> Values:
    """The course `form` at evenly spaced times. path: what grows with use, for "path". Raises KeyError for no such."""
    end = float(time_s[-1])
    t = np.clip((time_s - onset_s) / max(end - onset_s, 1e-9), 0.0, 1.0)
    chance = np.random.default_rng((seed, 71))
    if form == "random_walk":
        return _random_walk(time_s, onset_s, chance)
    if form == "path" and path is not None:
        grown = np.maximum(path - np.interp(onset_s, time_s, path), 0.0)
        return np.asarray(grown / max(grown[-1], 1e-12))
    return _SHAPES[form](t, chance)


def _exponential(t: Values, chance: np.random.Generator) -> Values:
    rate = float(chance.uniform(2.0, 6.0))
    return np.asarray((1.0 - np.exp(-rate * t)) / (1.0 - np.exp(-rate)))


def _bent(t: Values, chance: np.random.Generator) -> Values:
    """Linear, then in part back."""
    turn = float(chance.uniform(0.5, 0.75))
    return np.asarray(np.where(t < turn, t / turn, 1.0 - 0.6 * (t - turn) / (1.0 - turn)))


def _random_walk(time_s: Values, onset_s: float, chance: np.random.Generator) -> Values:
    """A random walk, of which the root mean square is a half."""
    coarse = np.arange(0.0, time_s[-1] + 0.2, 0.1)
    step = np.where(coarse[1:] > onset_s, chance.normal(size=len(coarse) - 1), 0.0)
    walk = np.concatenate(([0.0], np.cumsum(step)))
    walk *= 0.5 / max(float(np.sqrt(np.mean(walk**2))), 1e-9)
    return np.interp(time_s, coarse, walk)


def _steps_with_reset(t: Values, chance: np.random.Generator) -> Values:
    """Creeps, and jumps back in part where the scene is found again."""
    out = 1.6 * t
    for at in np.sort(chance.uniform(0.15, 0.95, int(chance.integers(1, 5)))):
        before = float(out[np.searchsorted(t, at)])
        out = np.where(t >= at, out - float(chance.uniform(0.3, 0.9)) * before, out)
    return np.asarray(out)


_SHAPES: dict[str, Callable[[Values, np.random.Generator], Values]] = {
    "linear": lambda t, chance: t,
    "sqrt": lambda t, chance: np.sqrt(t),
    "exponential": _exponential,
    "bent": _bent,
    "steps_with_reset": _steps_with_reset,
}


def wander(time_s: Values, tau_s: float, chance: np.random.Generator) -> Values:
    """A stationary process of unit variance, correlated over tau_s, smooth within a fifth of it."""
    step = min(tau_s / 10.0, 0.5)
    coarse = np.arange(time_s[0] - 5.0 * step, time_s[-1] + 6.0 * step, step)
    keep = float(np.exp(-step / tau_s))
    noise = chance.normal(size=len(coarse)) * np.sqrt(1.0 - keep * keep)
    value, out = float(chance.normal()), np.empty(len(coarse))
    for k in range(len(coarse)):
        value = keep * value + noise[k]
        out[k] = value
    return np.interp(time_s, coarse, out)


def poisson(rate_hz: float, duration_s: float, chance: np.random.Generator, onset_s: float = 0.0) -> Values:
    """Instants of a Poisson process, one at least."""
    count = max(1, int(chance.poisson(rate_hz * (duration_s - onset_s))))
    return np.sort(chance.uniform(onset_s, duration_s, count))
