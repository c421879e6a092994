"""What a recording holds of a joint that is driven by a torque, a current or a voltage: one input, some outputs.

Units may be unknown. The input's scale is then part of the joint's gain; an output's scale is fitted or left to the
unit in which the model states its quantity.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stillarm.common.recording.reader import Recording
from stillarm.common.user_error import UserError
from stillarm.tables.unscaled import unscaled_channels

Array = NDArray[np.float64]
Kind = Literal["position", "motor", "velocity", "deflection", "acceleration"]

INPUTS = (
    "motor_current_a",
    "motor_current_command_a",
    "joint_torque_command_n_m",
    "joint_torque_n_m",
    "motor_voltage_v",
)
"""Roles that drive the joint, the most direct first."""
MEASURED_INPUTS = ("motor_current_a", "joint_torque_n_m")
"""Those behind the amplifier: nothing that it does to its command comes between them and the joint."""
OUTPUTS: dict[str, Kind] = {
    "joint_position_rad": "position",
    "motor_position_rad": "motor",
    "joint_velocity_rad_s": "velocity",
    "deflection_m": "deflection",
    "strain": "deflection",
    "acceleration_m_s2": "acceleration",
}
_FEWEST = 200  # samples of a channel
_FEWEST_VALUES = 4  # different ones: of fewer a channel is a switch, no measurement
MOST_SAMPLES = 60_000  # beyond that every second one is taken, and so on
_COUNTED_SHARE = 0.98  # of the values on the grid of their smallest step: an encoder or a converter


@dataclass(frozen=True)
class Output:
    """One measured channel. values: (n,), NaN where not measured; stated: whether its unit is known; step: of its
    counter or converter, in its unit, 0 where values lie on no grid."""

    name: str
    kind: Kind
    values: Array
    stated: bool
    step: float


@dataclass(frozen=True)
class Driven:
    """A rig with one input. u: (n,); step_s: between samples. joins: first sample of each recording but the first,
    where several follow each other."""

    name: str
    step_s: float
    origin_s: float
    drive: str
    u: Array
    drive_stated: bool
    outputs: tuple[Output, ...]
    left_out: dict[str, str]
    joins: tuple[int, ...] = ()

    @property
    def samples(self) -> int:
        """How many there are."""
        return len(self.u)

    @property
    def duration_s(self) -> float:
        """Time that they span, s."""
        return self.samples * self.step_s

    @property
    def recordings(self) -> int:
        """How many there are."""
        return len(self.joins) + 1

    def part(self, recording: int) -> "Driven":
        """One of the recordings by itself."""
        edges = (0, *self.joins, self.samples)
        inside = slice(edges[recording], edges[recording + 1])
        outputs = tuple(replace(one, values=one.values[inside]) for one in self.outputs)
        return replace(self, u=self.u[inside], outputs=outputs, joins=())

    def with_outputs(self, *kinds: str) -> "Driven":
        """The same with some kinds of outputs only."""
        return replace(self, outputs=tuple(one for one in self.outputs if one.kind in kinds))


def is_driven(recording: Recording) -> bool:
    """Whether a joint is driven by a torque, a current or a voltage, and what it does was measured."""
    if not recording.counts.get("/fast"):
        return False
    named = _channels(recording)
    commanded = "joint_velocity_command_rad_s" in named or "joint_velocity_reference_rad_s" in named
    return not commanded and any(one in named for one in INPUTS) and any(one in named for one in OUTPUTS)


def read_driven(recording: Recording) -> Driven:
    """The input and the outputs on one grid. Raises UserError where they are too few."""
    named = _channels(recording)
    role = next(one for one in INPUTS if one in named)
    time, values, drive_stated = named[role]
    step = float(np.median(np.diff(time)))
    if not step > 0.0:
        raise UserError(f"{recording.path}: time_s does not grow; correct the time column, and import again")
    thin = 1 + int((time[-1] - time[0]) / step / MOST_SAMPLES)
    grid = np.arange(time[0], time[-1] + 0.5 * step, step)
    if len(grid) > 40 * len(time) + 1000:
        raise UserError(
            f"{recording.path}: {len(time)} rows span {time[-1] - time[0]:.0f} s; cut the recording where it was "
            "interrupted"
        )
    u = np.interp(grid, time, values)
    outputs, left_out = [], {}
    for name, kind in OUTPUTS.items():
        if name not in named:
            continue
        there, read, stated = named[name]
        if len(read) < _FEWEST or len(np.unique(read)) < _FEWEST_VALUES:
            left_out[name] = "too few values that differ"
            continue
        outputs.append(Output(name, kind, _on(grid, there, read), stated, counter_step(read)))
    if not outputs or np.std(u) == 0.0:
        why = "is constant" if np.std(u) == 0.0 else "moves nothing measured"
        raise UserError(
            f"{recording.path}: nothing to diagnose: the input {role} {why}; give at least {_FEWEST} samples of a "
            "joint position, velocity, deflection or acceleration that vary"
        )
    driven = Driven(
        str(recording.path), step, float(time[0]), role, u, drive_stated, tuple(outputs), left_out
    )
    return thinned(driven, thin)


def thinned(driven: Driven, every: int) -> Driven:
    """Every so many samples; the input is averaged over those left out."""
    if every <= 1:
        return driven
    n = driven.samples // every * every
    u = driven.u[:n].reshape(-1, every).mean(axis=1)
    outputs = tuple(replace(one, values=one.values[:n:every]) for one in driven.outputs)
    return replace(driven, step_s=driven.step_s * every, u=u, outputs=outputs)


def counter_step(values: Array) -> float:
    """The step on whose multiples the values lie; 0 where they lie on none that shows."""
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < _FEWEST_VALUES or len(levels) > 0.5 * len(values) + 16:
        return 0.0
    gaps = np.diff(levels)
    step = float(np.min(gaps[gaps > 1e-9 * np.ptp(levels)], initial=np.inf))
    if not np.isfinite(step):
        return 0.0
    near = gaps[gaps < 3.5 * step]
    step = float(np.median(near / np.maximum(np.rint(near / step), 1.0)))
    off = np.abs(gaps / step - np.rint(gaps / step))
    return step if np.mean(off < 0.05) > _COUNTED_SHARE else 0.0


def _channels(recording: Recording) -> dict[str, tuple[Array, Array, bool]]:
    """By role: times, values, and whether the unit is stated; only what was measured."""
    fast = recording.columns("/fast")
    found: dict[str, tuple[Array, Array, bool]] = {}
    wanted = (*INPUTS, *OUTPUTS, "joint_velocity_command_rad_s", "joint_velocity_reference_rad_s")
    for name in wanted:
        values = fast.get(name)
        if values is not None and np.isfinite(values).any():
            found[name] = _ordered(fast["time_s"], values, name != "strain")
    for one in unscaled_channels(recording):
        if one.role in wanted and one.role not in found:
            found[one.role] = _ordered(one.time_s, one.values, False)
    return found


def _ordered(time: Array, values: Array, stated: bool) -> tuple[Array, Array, bool]:
    known = np.isfinite(values) & np.isfinite(time)
    time, values = time[known], values[known]
    time, first = np.unique(time, return_index=True)
    return time, values[first], stated


def _on(grid: Array, time: Array, values: Array) -> Array:
    """The nearest value within half a step; NaN where there is none."""
    step = grid[1] - grid[0]
    place = np.rint((time - grid[0]) / step).astype(np.int64)
    inside = (place >= 0) & (place < len(grid))
    out = np.full(len(grid), np.nan)
    out[place[inside]] = values[inside]
    return out
