"""What is left after all findings: tests for structure, and a black box that tries to predict it.

A ridge regression on a library of functions of the simulated state (amplitude, velocity, sign, position, time, input),
trained on the training part and judged on the held-out part: if it predicts the residual, something is unexplained.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.fit import Data, Fit

Array = NDArray[np.float64]

_LAGS = 12


@dataclass(frozen=True)
class Structure:
    """What is known of a channel's residual.

    white: whether it passes. reduction: share of the held-out variance that the black box predicts; nats: what that
    gains, held out; std_nats: its standard error over blocks. memory: correlation from sample to sample. band_hz:
    where most of the excess power lies. dependence: what the residual depends on most, in words.
    """

    channel: str
    white: bool
    reduction: float
    nats: float
    std_nats: float
    memory: float
    band_hz: tuple[float, float]
    dependence: str
    term: str


def _features(last: Fit, name: str) -> tuple[list[str], Array]:
    """Functions of the simulated motion at each sample of a channel, each scaled to one."""
    world, motion = last.world, last.predicted.motion
    q, slope = motion.q[:, 0], np.gradient(motion.q[:, 0]) / world.measured.cycle_s
    theta, omega, alpha = motion.joint[:, 0], motion.joint[:, 1], motion.joint[:, 2]
    command = np.nan_to_num(world.measured.command)
    force = world.measured.force if world.measured.pair else np.zeros(len(q))
    acceleration = motion.tip_acceleration
    t = np.arange(len(q)) * world.measured.cycle_s

    def unit(values: Array) -> Array:
        size = float(np.max(np.abs(values)))
        return values / size if size > 0.0 else values

    q, slope, theta, omega, alpha = unit(q), unit(slope), unit(theta), unit(omega), unit(alpha)
    command, acceleration, force = unit(command), unit(acceleration), unit(force)
    fast = {
        "deflection": q,
        "deflection squared": q * q,
        "deflection cubed": q**3,
        "deflection speed": slope,
        "speed times its size": slope * np.abs(slope),
        "sign of the deflection speed": np.sign(slope) * (np.abs(slope) > 0.01),
        "amplitude times speed": np.abs(q) * slope,
        "deflection times its size": q * np.abs(q),
        "joint position": theta,
        "joint position squared": theta * theta,
        "sine of 10 times the joint's turn": np.sin(10.0 * motion.joint[:, 0]),
        "cosine of 10 times the joint's turn": np.cos(10.0 * motion.joint[:, 0]),
        "joint velocity": omega,
        "joint velocity times its size": omega * np.abs(omega),
        "sign of the joint velocity": np.sign(omega) * (np.abs(omega) > 0.01),
        "joint acceleration": alpha,
        "command": command,
        "input": force,
        "tip acceleration": acceleration,
        "tip acceleration times its size": acceleration * np.abs(acceleration),
        "tip acceleration cubed": acceleration**3,
        "time": t / t[-1],
        "time squared": (t / t[-1]) ** 2,
        "deflection times time": q * t / t[-1],
        "speed times time": slope * t / t[-1],
        "tip acceleration times time": acceleration * t / t[-1],
        "joint position times time": theta * t / t[-1],
    }
    names, columns = [], []
    if name in ("displacement", "arrival"):
        at = world.instants(last.vector)
        fast = {key: np.interp(at, t, values) for key, values in fast.items()}
    for key, values in fast.items():
        spread = float(np.std(values))
        if spread > 1e-9:
            names.append(key)
            columns.append((values - values.mean()) / spread)
    return names, np.stack(columns, axis=1)


def examine(data: Data, last: Fit, name: str) -> Structure:
    """Look at one channel's residual."""
    residual = last.residuals[name] / last.sigma[name]
    known = np.isfinite(residual)
    residual = np.clip(np.nan_to_num(residual), -8.0, 8.0)
    residual[known] -= residual[known].mean()
    train, held = data.train[name], data.held[name]
    if not held.any():
        held = train
    names, x = _features(last, name)
    ridge = 1e-3 * train.sum()
    gram = x[train].T @ x[train] + ridge * np.eye(x.shape[1])
    weights = np.linalg.solve(gram, x[train].T @ residual[train])
    guess = x @ weights
    gains = 0.5 * (residual**2 - (residual - guess) ** 2)
    power = float(np.mean(residual[held] ** 2)) or 1.0
    reduction = float(2.0 * gains[held].sum() / (held.sum() * power))
    per_block = np.bincount(data.blocks[name][held], gains[held] / power, len(data.split.held))[
        data.split.held
    ]
    nats = float(per_block.sum())
    spread = float(np.std(per_block) * np.sqrt(len(per_block))) if len(per_block) > 1 else nats
    # memory: linear prediction of each sample from those before it
    memory = _memory(residual, train, held, power)
    band = _band(last, name, residual)
    each = np.abs(x[train].T @ residual[train]) / train.sum()
    strongest = int(np.argmax(each))
    limit = 4.0 / np.sqrt(max(train.sum(), 1))
    dependence = (
        names[strongest] if each[strongest] > limit else ("none found" if memory < 0.02 else "its own past")
    )
    white = not (nats > max(8.0, 2.0 * spread) and reduction > 0.005) and memory < 0.02
    return Structure(
        name, white, max(reduction, 0.0), nats, spread, memory, band, dependence, _term(names, weights)
    )


def _memory(residual: Array, train: NDArray[np.bool_], held: NDArray[np.bool_], power: float) -> float:
    """Share of the held-out variance that a sample's own past predicts."""
    n = len(residual)
    if n < 10 * _LAGS:
        return 0.0
    past = np.stack([np.concatenate((np.zeros(lag), residual[:-lag])) for lag in range(1, _LAGS + 1)], axis=1)
    gram = past[train].T @ past[train] + 1e-3 * train.sum() * np.eye(_LAGS)
    weights = np.linalg.solve(gram, past[train].T @ residual[train])
    guess = past[held] @ weights
    rest = residual[held] - guess
    return max(0.0, 1.0 - float(np.mean(rest**2)) / power)


def _band(last: Fit, name: str, residual: Array) -> tuple[float, float]:
    """Band, Hz, that holds the middle four fifths of the power above the median level."""
    world = last.world
    step = (
        1.0 / world.model.camera.frame_rate_hz
        if name in ("displacement", "arrival")
        else world.measured.cycle_s
    )
    n = min(len(residual), 4096)
    count = max(1, len(residual) // n)
    pieces = residual[: n * count].reshape(count, n) * np.hanning(n)
    power = np.mean(np.abs(np.fft.rfft(pieces, axis=1)) ** 2, axis=0)[1:]
    hz = np.fft.rfftfreq(n, step)[1:]
    excess = np.clip(power - 1.5 * np.median(power), 0.0, None)
    if excess.sum() <= 0.0:
        return (float(hz[0]), float(hz[-1]))
    share = np.cumsum(excess) / excess.sum()
    return (
        float(hz[np.searchsorted(share, 0.1)]),
        float(hz[min(int(np.searchsorted(share, 0.9)), len(hz) - 1)]),
    )


def _term(names: list[str], weights: Array) -> str:
    order = np.argsort(-np.abs(weights))[:3]
    return " + ".join(f"{weights[i]:.3g} x ({names[i]})" for i in order) + " (standard deviations)"
