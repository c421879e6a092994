"""Terms without a name: what a residual may depend on, whatever the cause.

Forces on the first mode (answered by all channels, through the mode), and things added to one sensor. Chosen one after
another by what they explain of the training part beside the fitted parameters (orthogonal matching pursuit; Pati,
Rezaiifar and Krishnaprasad, 1993), judged on the held-out part. A named cause has to do better than these.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import log, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from stillarm.diagnosis.fit import THIN, Data, Fit, jacobian, thinned, thinned_mask
from stillarm.diagnosis.world import Motion

Array = NDArray[np.float64]

_MOST_TERMS = 6
_WAVES = 12
_WAVE_S = 1.5
_CLIP = 8.0
_MOUNT_HZ = tuple(float(hz) for hz in np.geomspace(3.0, 40.0, 20))
_MOUNT_DAMPING = 0.06
_HOLDS = (0.3, 1.0, 2.0)  # deviations of what shakes a mount, up to which friction holds it


@dataclass(frozen=True)
class Term:
    """A dependence in words, and its change of each channel that it touches."""

    name: str
    channel: str
    change: dict[str, Array]


@dataclass(frozen=True)
class Explained:
    """Terms chosen, with their amounts; nats: gained of the training part and of each held-out block.

    first_nats, first_blocks: what the first term alone gains of either. channel: where the first one acts.
    """

    names: tuple[str, ...]
    amounts: tuple[float, ...]
    channel: str
    train_log_likelihood: float
    first_nats: float
    block_nats: Array
    first_blocks: Array


def explained(data: Data, last: Fit) -> Explained:
    """What terms without a name explain of a fit's residual."""
    parts = _Parts(data, last)
    columns = _Columns(parts)
    names, acts_on = [], []
    for term in _terms(last):
        columns.add(parts.pieces(term.change))
        names.append(term.name)
        acts_on.append(term.channel)
    # beside the fitted parameters: q is an orthonormal basis of their slopes on the training part, zero elsewhere
    train, base, q = parts.train, parts.base, np.zeros_like(parts.base)
    q[train], _ = np.linalg.qr(base[train])
    residual = np.where(train, parts.residual, 0.0)
    residual -= q @ (q.T @ residual)
    shares = columns.times(q)
    whole = columns.training_sizes()
    size = np.sqrt(np.maximum(whole**2 - np.sum(shares**2, axis=1), 0.0))
    usable = (size > 1e-3 * whole) & (size > 1e-9)
    chosen: list[int] = []
    gained, first = 0.0, 0.0
    rest = residual
    least = 3.0 + log(max(len(names), 1))
    reach = np.array([parts.reach if name == "joint_position" else 0.0 for name in acts_on])
    while len(chosen) < _MOST_TERMS:
        share = columns.times(rest) / np.maximum(size, 1e-12)
        exact = np.abs(share) * whole < reach * np.maximum(size, 1e-12)  # as far as a simulation goes
        score = np.where(usable & ~exact, share**2, 0.0)
        score[chosen] = 0.0
        best = int(np.argmax(score))
        if 0.5 * score[best] < least:
            break
        chosen.append(best)
        x = columns.whole(chosen) * train[:, None]
        x -= q @ (q.T @ x)
        amounts, *_ = np.linalg.lstsq(x, residual, rcond=None)
        rest = residual - x @ amounts
        gained = 0.5 * float(residual @ residual - rest @ rest)
        first = gained if len(chosen) == 1 else first
    if not chosen:
        nothing = np.zeros(len(data.split.held))
        return Explained((), (), "", 0.0, 0.0, nothing, nothing)
    count = len(data.split.held)
    weights, blocks = _held_out(parts, columns.whole(chosen), count)
    alone = blocks if len(chosen) == 1 else _held_out(parts, columns.whole(chosen[:1]), count)[1]
    return Explained(
        tuple(names[i] for i in chosen),
        tuple(float(w) for w in weights),
        acts_on[chosen[0]],
        gained,
        first,
        blocks,
        alone,
    )


def _held_out(parts: "_Parts", terms: Array, blocks: int) -> tuple[Array, Array]:
    """Amounts of terms (samples, terms) beside the fitted parameters, and what they gain of each held-out block."""
    train, held = parts.train, parts.held
    x = np.concatenate((parts.base, terms), axis=1)
    weights, *_ = np.linalg.lstsq(x[train], parts.residual[train], rcond=None)
    after = parts.residual - x @ weights
    gains = 0.5 * (parts.residual**2 - after**2)
    found = np.bincount(parts.block[held], gains[held], blocks).astype(np.float64)
    return weights[parts.base.shape[1] :], found


class _Parts:
    """All channels' whitened residuals over their levels, one after the other, with the fitted parameters' slopes.

    spans: which samples of the whole are a channel's.
    """

    def __init__(self, data: Data, last: Fit) -> None:
        self.last = last
        slopes = jacobian(last.world, last.vector, last.free, last.predicted, last.colour)
        self._std = {name: last.sigma[name] / THIN.get(name, 1) ** 0.5 for name in last.residuals}
        residual, base, train, held, block = [], [], [], [], []
        self.spans: dict[str, slice] = {}
        at = 0
        for name, values in last.residuals.items():
            u = np.nan_to_num(thinned(name, values)) / self._std[name]
            self.spans[name] = slice(at, at + len(u))
            at += len(u)
            residual.append(np.clip(u, -_CLIP, _CLIP))
            base.append(slopes[name] / self._std[name])
            train.append(thinned_mask(name, data.train[name]))
            held.append(thinned_mask(name, data.held[name]))
            step = THIN.get(name, 1)
            block.append(data.blocks[name][: len(u) * step : step])
        self.reach = self._reach(data)
        self.residual = np.concatenate(residual)
        whole = np.nan_to_num(np.concatenate(base))
        norms = np.linalg.norm(whole, axis=0)
        self.base = whole[:, norms > 1e-12] / norms[norms > 1e-12]
        self.train, self.held = np.concatenate(train), np.concatenate(held)
        self.block = np.concatenate(block)

    def _reach(self, data: Data) -> float:
        """How long a joint position's change is, as a vector over the level, that the simulation may be off by itself:
        its limit of acceleration ends within a cycle, where that of a drive that works in cycles ends with one, which
        leaves the joint off by up to a cycle of it, squared, over two. Over thousands of samples even a tenth of an
        encoder's step shows."""
        name, world = "joint_position", self.last.world
        if name not in self.last.residuals:
            return 0.0
        off = 0.5 * world.model.drive.max_acceleration_rad_s2 * world.measured.cycle_s**2
        count = int(thinned_mask(name, data.train[name]).sum())
        return float(off / self._std[name] * sqrt(count))

    def pieces(self, change: dict[str, Array]) -> dict[str, Array]:
        """A change of the channels that it touches, as their residuals are: whitened, thinned, over the level."""
        found = {}
        for name, values in change.items():
            colour = self.last.colour.get(name)
            white = colour.whiten(values) if colour is not None else values
            found[name] = np.nan_to_num(thinned(name, white)) / self._std[name]
        return found


class _Columns:
    """What each term changes, kept by channel: most touch one alone, and the whole would be zeros for the most part."""

    def __init__(self, parts: _Parts) -> None:
        self._parts = parts
        self._rows: dict[str, list[Array]] = {name: [] for name in parts.spans}
        self._of: dict[str, list[int]] = {name: [] for name in parts.spans}
        self._count = 0

    def add(self, pieces: dict[str, Array]) -> None:
        """One more term."""
        for name, values in pieces.items():
            self._rows[name].append(values)
            self._of[name].append(self._count)
        self._count += 1

    def times(self, others: Array) -> Array:
        """Inner products of each term with vectors over the whole, (samples,) or (samples, k): (terms,) or
        (terms, k).
        """
        found = np.zeros((self._count, *others.shape[1:]))
        for name, span in self._parts.spans.items():
            for index, row in zip(self._of[name], self._rows[name], strict=True):
                found[index] += row @ others[span]
        return found

    def training_sizes(self) -> Array:
        """Length of each term's part that trains, (terms,)."""
        found = np.zeros(self._count)
        for name, span in self._parts.spans.items():
            train = self._parts.train[span]
            for index, row in zip(self._of[name], self._rows[name], strict=True):
                part = row[train]
                found[index] += part @ part
        result: Array = np.sqrt(found)
        return result

    def whole(self, chosen: list[int]) -> Array:
        """Those terms over the whole, (samples, chosen)."""
        found = np.zeros((len(self._parts.residual), len(chosen)))
        for name, span in self._parts.spans.items():
            for place, index in enumerate(chosen):
                if index in self._of[name]:
                    found[span, place] = self._rows[name][self._of[name].index(index)]
        return found


def _terms(last: Fit) -> Iterator[Term]:
    yield from _forces(last)
    yield from _on_sensors(last)


def _unit(values: Array) -> Array:
    size = float(np.max(np.abs(values)))
    return values / size if size > 0.0 else values


def _forces(last: Fit) -> Iterator[Term]:
    """Accelerations of the first mode, as the channels would answer them."""
    world, motion = last.world, last.predicted.motion
    h = world.measured.cycle_s
    q = _unit(motion.q[:, 0])
    v = _unit(np.gradient(motion.q[:, 0]))
    theta, omega = motion.joint[:, 0], _unit(motion.joint[:, 1])
    size = np.sqrt(np.maximum(q * q + v * v, 1e-12))
    t = np.arange(len(q)) * h
    forces = {
        "deflection squared": q * q,
        "deflection times its size": q * np.abs(q),
        "positive deflection": np.maximum(q, 0.0),
        "deflection cubed": q**3,
        "sign of the deflection": np.tanh(20.0 * q),
        "speed times its size": v * np.abs(v),
        "sign of the deflection speed": np.tanh(20.0 * v),
        "amplitude times speed": size * v,
        "amplitude times deflection": size * q,
        "deflection over its amplitude": q / np.maximum(size, 0.02),
        "speed over its amplitude": v / np.maximum(size, 0.02),
        "deflection, half a second late": _slow(q, h, 0.5),
        "deflection, two seconds late": _slow(q, h, 2.0),
        "joint velocity": omega,
        "joint velocity times its size": omega * np.abs(omega),
        "sign of the joint velocity": np.tanh(20.0 * omega),
        "joint position times deflection": _unit(theta) * q,
        "joint velocity times deflection": omega * q,
    }
    for turns in (1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0):
        forces[f"sine of {turns:g} times the joint's turn"] = np.sin(turns * theta)
        forces[f"cosine of {turns:g} times the joint's turn"] = np.cos(turns * theta)
    for m in range(1, 5):
        forces[f"deflection times slow time ({m})"] = q * np.cos(pi * m * t / t[-1])
    for name, force in forces.items():
        yield Term(f"force: {name}", "arm", _answer(last, force - float(force.mean())))


def _slow(values: Array, step_s: float, time_s: float) -> Array:
    stay = float(np.exp(-step_s / time_s))
    out: Array = lfilter([1.0 - stay], [1.0, -stay], values)
    return out


def _answer(last: Fit, force: Array) -> dict[str, Array]:
    """What a force per mass on the first mode changes in each channel: q'' + 2 z w q' + w^2 q = f (bilinear)."""
    world = last.world
    h = world.measured.cycle_s
    w = 2.0 * pi * last.value("modes.0.frequency_hz")
    z = last.value("modes.0.damping_ratio")
    k = 2.0 / h
    a0, a1, a2 = k * k + 2 * z * w * k + w * w, 2 * (w * w - k * k), k * k - 2 * z * w * k + w * w
    q = lfilter([1.0 / a0, 2.0 / a0, 1.0 / a0], [1.0, a1 / a0, a2 / a0], force)
    v = np.gradient(q) / h
    change: dict[str, Array] = {}
    if "deflection" in world.channels:
        change["deflection"] = q
    if "acceleration" in world.channels:
        change["acceleration"] = last.value("accelerometer.scale") * (force - 2 * z * w * v - w * w * q)
    if "displacement" in world.channels:
        instants = world.instants(last.vector)
        change["displacement"] = -last.value("camera.scale_px_per_m") * np.interp(
            instants, world.cycle_times, q
        )
    return change


def _beyond(shaken: Array, hold: float) -> Array:
    """What of an acceleration is more than friction holds, which is `hold` times its deviation."""
    limit = hold * float(np.std(shaken))
    return np.asarray(shaken - np.clip(shaken, -limit, limit))


def _mounts(motion: Motion, step_s: float) -> Iterator[tuple[str, Array]]:
    """How a mount of each frequency is shaken, held elastically or by friction that lets go, at each cycle."""
    alpha, a = _unit(motion.joint[:, 2]), _unit(motion.tip_acceleration)
    shakes = {"shaken by the joint's acceleration": alpha, "shaken by the tip's acceleration": a}
    for hold in _HOLDS:
        shakes[f"loose beyond {hold:g} of the tip's acceleration"] = _beyond(a, hold)
    for hz in _MOUNT_HZ:
        for by, shaken in shakes.items():
            for what, values in _rings(shaken, step_s, hz).items():
                yield f"a mount of {hz:.3g} Hz, {by} ({what})", values


def _rings(shaken: Array, step_s: float, hz: float) -> dict[str, Array]:
    """Displacement and rate, each over its largest, of a lightly damped mount that is shaken."""
    pole = np.exp((-_MOUNT_DAMPING + 1j) * 2.0 * pi * hz * step_s)
    turn = lfilter([1.0], [1.0, -pole], shaken)
    return {"in phase": _unit(turn.real.copy()), "across": _unit(turn.imag.copy())}


def _on_sensors(last: Fit) -> Iterator[Term]:
    """Things added to one channel."""
    world, motion = last.world, last.predicted.motion
    theta, omega, alpha = motion.joint[:, 0], _unit(motion.joint[:, 1]), _unit(motion.joint[:, 2])
    q, a = _unit(motion.q[:, 0]), _unit(motion.tip_acceleration)
    t = world.cycle_times
    length = max(world.measured.duration_s, 1e-3)
    waves = min(_WAVES, max(2, int(length / _WAVE_S)))
    for name in world.channels:
        if name == "arrival":
            continue
        own = _unit(last.predicted.channels[name] - float(np.nanmean(last.predicted.channels[name])))
        at = world.instants(last.vector) if name == "displacement" else t

        def seen(values: Array, at: Array = at, name: str = name) -> Array:
            return np.interp(at, t, values) if name == "displacement" else values

        plain = {
            "its own size": own * np.abs(own),
            "its own square": own * own,
            "its own cube": own**3,
            "sign of itself": np.tanh(20.0 * own),
            "joint velocity": seen(omega),
            "joint velocity times its size": seen(omega * np.abs(omega)),
            "sign of the joint velocity": seen(np.tanh(20.0 * omega)),
            "joint position": seen(_unit(theta)),
            "joint position squared": seen(_unit(theta) ** 2),
            "joint acceleration": seen(alpha),
            "deflection": seen(q),
            "deflection squared": seen(q * q),
            "tip acceleration": seen(a),
            "time": at / length,
            "time squared": (at / length) ** 2,
        }
        for turns in (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0):
            plain[f"sine of {turns:g} times the joint's turn"] = seen(np.sin(turns * theta))
            plain[f"cosine of {turns:g} times the joint's turn"] = seen(np.cos(turns * theta))
        for m in range(1, waves + 1):
            plain[f"a gain that wanders ({m})"] = own * np.cos(pi * m * at / length)
            plain[f"a wander ({m})"] = np.cos(pi * m * at / length)
        if name in ("displacement", "acceleration", "deflection"):
            for lag in (0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.13, 0.16, 0.2, 0.25):
                late = np.interp(at - lag, t, alpha)
                plain[f"joint acceleration {lag * 1000:.0f} ms before"] = late
        if name == "displacement":
            plain |= {what: seen(values) for what, values in _mounts(motion, world.measured.cycle_s)}
            pixels = last.predicted.channels[name]
            for turns in (1.0, 2.0):
                plain[f"sine of the place in the pixel ({turns:g})"] = np.sin(2 * pi * turns * pixels)
                plain[f"cosine of the place in the pixel ({turns:g})"] = np.cos(2 * pi * turns * pixels)
        for what, values in plain.items():
            yield Term(what, name, {name: values - float(np.nanmean(values))})
