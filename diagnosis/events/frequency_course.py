"""How the arm's frequency goes over the recording, where it changes by more than small steps from one frequency show.

In each window of a few periods the vibration is what the joint's motion makes of a mode of some frequency, and a free
vibration; both are linear but for the frequency, and are projected out (variable projection: Golub and Pereyra, 1973),
so that each window has a likelihood of the frequency alone, whatever impacts the other windows hold. Three courses are
held against one frequency: a single change, a drift, and w^2 (1 + 3/4 c A^2) with the amplitude A of the vibration (the
first order of a cubic stiffness). They are where refits start, no more: those decide.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Mode, Model
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.physics.arm_motion import Motion
from stillarm.diagnosis.physics.copies import shared_out
from stillarm.diagnosis.physics.linear_modes import acceleration_of_mode, deflection_of_mode
from stillarm.diagnosis.physics.quantities import HIGHER
from stillarm.diagnosis.physics.window_fits import swings_in_windows
from stillarm.diagnosis.physics.world import World

Array = NDArray[np.float64]

_PERIODS = 4.0  # of a window
_PER_PERIOD = 24  # samples
_FINER = 4  # times as fine is what a mode's answer is worked out in: 2 % of a turn at the highest frequency
_RATIOS = np.exp(np.linspace(np.log(0.6), np.log(1.6), 197))  # half a per cent apart
_DAMPING = 0.01  # ratio taken for the mode in every window: that of a usual arm
_WITHIN = 1e-9  # of the largest term: what is left of one that the others hold already is rounding
_LEAST_NATS = 15.0  # over one frequency: three million to 1, if the samples' noise is white
_LEAST_CHANGE = 0.015  # of a frequency: three steps of _RATIOS
_LEAST_OF_BEST = 0.5  # nats: a course that explains less is not worth a start
_FAR = 0.03  # of a frequency: beyond it the phase is a quarter turn off within eight periods
_FEWEST = 3  # windows on either side of a change
# tried: of a frequency to the recording's end, or of its square at the largest amplitude
_CHANGES = np.concatenate([-np.geomspace(0.5, 0.01, 40), np.geomspace(0.01, 1.0, 40)])
_PIECES = 16  # of a recording: the length of a segment of its spectrum, of which 31 overlap by half


@dataclass(frozen=True)
class Course:
    """One way in which the frequency goes. start: quantities of the world's vector; nats: gained over one frequency."""

    start: dict[str, float]
    nats: float

    def starts(self, world: World) -> list[dict[str, float]]:
        """The same, with what higher modes may take of it; a stiffness that changes with the deflection is the first
        mode's alone."""
        alone = not any(name.startswith("arm.frequency") for name in self.start)
        return [{**self.start, **others} for others in (({},) if alone else shares(world))]


def shares(world: World) -> tuple[Mapping[str, float], ...]:
    """What to start from: higher modes that change in proportion, and where there are some, that do not at all."""
    return ({HIGHER: 1.0}, {HIGHER: 0.0}) if world.modes > 1 else ({},)


@dataclass(frozen=True)
class _Windows:
    """Of each window: middle, s, and amplitude of the vibration, m; cost: its negative log-likelihood at each hz."""

    middle_s: Array
    amplitude_m: Array
    hz: Array
    cost: Array

    def along(self, shape: Array) -> tuple[int, float]:
        """The likeliest of all courses hz * shape, one value a window: place of its hz, and its cost."""
        step = np.log(self.hz[1] / self.hz[0])  # they lie evenly in the logarithm
        places = np.arange(len(self.hz))[:, None] + np.rint(np.log(shape) / step).astype(np.int64)
        costs = self.cost[np.arange(len(shape)), np.clip(places, 0, len(self.hz) - 1)].sum(axis=1)
        best = int(np.argmin(costs))
        return best, float(costs[best])


def seen_frequency(world: World, motion: Motion, fitted_hz: float) -> float | None:
    """The one frequency, Hz, that explains all windows best, where it is far from the one that was fitted and explains
    them better. A free run that gets its phase wrong within a few periods has nothing to follow to the right one.

    motion: of a simulation, whose joint is near the true one.
    """
    windows = _seen(world, motion)
    if windows is None:
        return None
    cost = windows.cost.sum(axis=0)
    best = int(np.argmin(cost))
    fitted = int(np.argmin(np.abs(np.log(windows.hz / fitted_hz))))
    far = abs(float(np.log(windows.hz[best] / fitted_hz))) > _FAR
    return float(windows.hz[best]) if far and cost[fitted] - cost[best] > _LEAST_NATS else None


def frequency_courses(world: World, motion: Motion) -> dict[str, Course]:
    """The likeliest course of each kind, by the cause that makes it; without those that are no better than one
    frequency, or too little to matter.

    motion: of a simulation, whose joint is near the true one.
    """
    windows = _seen(world, motion)
    if windows is None:
        return {}
    alone = float(windows.cost.sum(axis=0).min())
    found = {}
    for cause, courses in (
        ("payload_change", _changed(windows)),
        ("stiffness_drift", _drifting(windows)),
        ("cubic_stiffness", _stiffening(windows)),
    ):
        cost, start = min(courses, key=lambda one: one[0])
        if alone - cost > _LEAST_NATS:
            found[cause] = Course(start, alone - cost)
    most = max((one.nats for one in found.values()), default=0.0)
    return {cause: one for cause, one in found.items() if one.nats > _LEAST_OF_BEST * most}


def _seen(world: World, motion: Motion) -> _Windows | None:
    """The windows of the channels that show the vibration; None where there are too few."""
    shown = [] if world.measured.pair else _shown(world, motion)
    if not shown:
        return None
    windows = _windows(world, shown)
    return windows if len(windows.cost) > 2 * _FEWEST else None


def _changed(windows: _Windows) -> Iterator[tuple[float, dict[str, float]]]:
    cost, hz = windows.cost, windows.hz
    for k in range(_FEWEST, len(cost) - _FEWEST):
        first, last = cost[:k].sum(axis=0), cost[k + 1 :].sum(axis=0)
        i, j = int(np.argmin(first)), int(np.argmin(last))
        ratio = float(hz[j] / hz[i])
        if abs(ratio - 1.0) < _LEAST_CHANGE and k > _FEWEST:
            continue
        whole = float(first[i] + last[j] + min(cost[k, i], cost[k, j]))
        yield (
            whole,
            {
                "modes.0.frequency_hz": float(hz[i]),
                "arm.onset_s": float(windows.middle_s[k]),
                "arm.frequency_ratio": ratio,
            },
        )


def _drifting(windows: _Windows) -> Iterator[tuple[float, dict[str, float]]]:
    end = float(windows.middle_s[-1])
    for change in _CHANGES:
        best, cost = windows.along(1.0 + change * windows.middle_s / end)
        hz, rate = float(windows.hz[best]), float(change) / end
        yield cost, {"modes.0.frequency_hz": hz, "arm.frequency_rate_per_s": rate}


def _stiffening(windows: _Windows) -> Iterator[tuple[float, dict[str, float]]]:
    shape = (windows.amplitude_m / float(np.max(windows.amplitude_m))) ** 2
    for change in _CHANGES:
        best, cost = windows.along(np.sqrt(1.0 + change * shape))
        cubic = float(change) / (0.75 * float(np.max(windows.amplitude_m)) ** 2)
        yield cost, {"modes.0.frequency_hz": float(windows.hz[best]), "arm.cubic_per_m2": cubic}


@dataclass(frozen=True)
class _Shown:
    """A channel that shows the vibration: values at times, s; what the joint makes of it by itself, (samples, m);
    forced: what its motion makes of a mode of some w, rad/s; per_m: value per metre of the vibration."""

    time_s: Array
    values: Array
    beside: Array
    forced: Callable[[float], Array]
    per_m: float


def _shown(world: World, motion: Motion) -> list[_Shown]:
    """The channels that show the vibration, at some samples a period."""
    h = world.measured.cycle_s
    f0 = world.model.arm.modes[0].frequency_hz
    fine = max(1, int(1.0 / (_FINER * _PER_PERIOD * f0) / h))
    many = fine * max(1, int(1.0 / (_PER_PERIOD * f0) / h / fine))
    step_s = fine * h
    pull = _means(world.length * motion.joint[:, 2], fine)
    shown = []
    felt, bent, seen = (world.channels.get(name) for name in ("acceleration", "deflection", "displacement"))

    def averaged(values: Array, beside: Array, answer: Callable[..., Array], per_m: float) -> _Shown:
        """A channel of the controller's grid."""
        means = _means(values, many)
        times_s = np.asarray(h * many * np.arange(len(means)), np.float64)

        def forced(w: float) -> Array:
            return _means(answer(-pull, w / (2.0 * pi), _DAMPING, step_s), many // fine)

        return _Shown(times_s, means, beside, forced, per_m)

    if felt is not None:
        per_m = world.model.accelerometer.scale * (2.0 * pi * f0) ** 2
        shown.append(averaged(felt, _means(pull, many // fine)[:, None], acceleration_of_mode, per_m))
    if bent is not None:
        shown.append(averaged(bent, np.empty((len(bent), 0)), deflection_of_mode, 1.0))
    per_px = world.model.camera.scale_px_per_m
    if seen is not None and per_px != 0.0:
        at_s = world.instants(world.space.vector())
        known = np.isfinite(at_s)
        at_s = at_s[known]
        turned = np.interp(at_s, world.cycle_times, motion.joint[:, 0])[:, None]
        grid_s = step_s * np.arange(len(pull)) + 0.5 * (step_s - h)  # the middles of what is averaged
        shown.append(
            _Shown(
                at_s,
                seen[known],
                turned,
                lambda w: np.interp(
                    at_s, grid_s, deflection_of_mode(-pull, w / (2.0 * pi), _DAMPING, step_s)
                ),
                per_px,
            )
        )
    return shown


def _windows(world: World, shown: Sequence[_Shown]) -> _Windows:
    """Windows of some periods, one after another; each channel has its own level in each."""
    f0 = world.model.arm.modes[0].frequency_hz
    long_s = _PERIODS / f0
    starts_s = np.asarray(long_s * np.arange(int(world.measured.duration_s / long_s)), np.float64)
    windows = [_within(one, starts_s, long_s) for one in shown]
    hz = f0 * _RATIOS

    def costs(one: float) -> Array:
        of_each = [channel.cost for channel in _solved(shown, windows, starts_s, 2.0 * pi * one)]
        return np.asarray(np.sum(of_each, axis=0))

    cost = np.array(shared_out(costs, hz.tolist())).T
    best = float(hz[int(np.argmin(cost.sum(axis=0)))])
    at_best = _solved(shown, windows, starts_s, 2.0 * pi * best)
    clearest = max(at_best, key=lambda channel: float(np.median(channel.clarity)))
    return _Windows(starts_s + 0.5 * long_s, clearest.amplitude_m, hz, cost)


def _within(one: _Shown, starts_s: Array, long_s: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Places of a channel's samples in the windows, one after another, and where each window's begin and the last's
    end."""
    known = np.isfinite(one.values)
    inside = [np.flatnonzero((one.time_s >= at) & (one.time_s < at + long_s) & known) for at in starts_s]
    firsts = np.cumsum([0, *(len(places) for places in inside)])
    return np.concatenate([*inside, np.empty(0, np.int64)]).astype(np.int64), firsts.astype(np.int64)


@dataclass(frozen=True)
class _Solved:
    """What one frequency makes of a channel in each window, (windows,). cost: negative log-likelihood of what it
    leaves, at its own level; amplitude_m: of the vibration; clarity: the vibration's rms over that of what is left."""

    cost: Array
    amplitude_m: Array
    clarity: Array


def _solved(
    shown: Sequence[_Shown],
    windows: Sequence[tuple[NDArray[np.int64], NDArray[np.int64]]],
    starts_s: Array,
    w: float,
) -> list[_Solved]:
    """Each channel's windows at a mode's w, rad/s."""
    found = []
    for one, (places, firsts) in zip(shown, windows, strict=True):
        left, swing = np.empty(len(starts_s)), np.empty(len(starts_s))
        forced, beside = np.ascontiguousarray(one.forced(w)), np.ascontiguousarray(one.beside)
        swings_in_windows(
            one.time_s,
            one.values,
            forced,
            beside,
            places,
            firsts,
            starts_s,
            w,
            _DAMPING,
            _WITHIN,
            left,
            swing,
        )
        level = np.where(np.isnan(left), 1.0, left)
        found.append(
            _Solved(
                0.5 * np.diff(firsts) * np.log(level),
                2.0**0.5 * swing / abs(one.per_m),
                np.where(np.isnan(left), 0.0, swing / np.sqrt(level)),
            )
        )
    return found


def _means(values: Array, many: int) -> Array:
    count = len(values) // many
    means: Array = values[: count * many].reshape(count, many).mean(axis=1)
    return means


def with_resonance_of(measured: Measured, model: Model) -> Model:
    """The model with one mode at the peak of |cross spectrum| / input's power (H1 estimate; Welch's means), and the
    damping ratio that the width of the peak tells."""
    force, out = measured.force, np.nan_to_num(measured.deflection)
    n = max(256, len(out) // _PIECES)
    window = np.hanning(n)
    cross, power = np.zeros(n // 2 + 1, complex), np.zeros(n // 2 + 1)
    for start in range(0, len(out) - n + 1, n // 2):
        u = np.fft.rfft((force[start : start + n] - force.mean()) * window)
        y = np.fft.rfft((out[start : start + n] - out.mean()) * window)
        cross += np.conj(u) * y
        power += np.abs(u) ** 2
    hz = np.fft.rfftfreq(n, measured.cycle_s)
    driven = power > 1e-4 * power.max()
    gain: Array = np.where(driven, np.abs(cross) / np.maximum(power, 1e-300), 0.0)
    gain[:2] = 0.0
    top = int(np.argmax(gain))
    above = np.flatnonzero(gain > gain[top] / 2.0**0.5)
    near = above[(above > top - n // 20) & (above < top + n // 20)]
    width = float(hz[near[-1]] - hz[near[0]]) if len(near) > 1 else float(hz[1])
    damping = min(max(0.5 * width / max(float(hz[top]), 1e-9), 0.002), 0.3)
    mode = Mode(frequency_hz=float(hz[top]), damping_ratio=damping)
    return msgspec.structs.replace(model, arm=msgspec.structs.replace(model.arm, modes=[mode]))
