"""A recording's rows put on a grid of cycles: gaps, steps of the clock, frames, and a command where none was recorded.

Rows that were written twice, or too early or late, are put in order. A clock that was set is no disorder: its rows lie
on places that other rows hold already, and stay as they are.

Where no command was recorded: the one that would have made the joint move as it was measured. The simulated drive is a
lag after a dead time, bandwidth_hz and dead_time_s of the model, so that
command(t) = omega(t + dead) + omega'(t + dead) / (2 pi bandwidth). omega and omega' are those of local cubics
(Savitzky and Golay, Analytical Chemistry 36, 1964).
"""

from math import nan, pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from stillarm.common.datagrams.visual_sample import TrackingStatus
from stillarm.common.files.model import Drive, Model
from stillarm.common.recording.reader import Recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.data.measured import ClockGap, Frames, Measured
from stillarm.diagnosis.data.robust import OUTLYING, bridged, std_about_median, std_about_zero

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

_LEAST_ROWS_A_PERIOD = 4  # of the first mode: fewer do not show how it decays between them
_STEP_CYCLES = 1.5  # a gap in time_s longer than this may be lost rows, or a clock that stepped
REGULAR = 0.25  # of the usual step, by which a regular one may differ
_WHOLE = 2e-3  # of a cycle: a row step so near to whole cycles is one of the model's cycles
_MOSTLY = 0.9  # of the steps: stamps that scatter more are kept apart by the model's finer grid
_OTHER_RATE = 1.5  # times the model's cycle, or less than its half: rows come at another rate
WINDOW_S = 0.06  # passes what a joint does up to some 15 Hz
MIN_TRAVEL = 50.0  # deviations of the sensor's noise: less is no motion, but the sensor


def read_measured(recording: Recording, model: Model) -> Measured:
    """The recording's channels. Raises UserError where there is nothing to diagnose."""
    if recording.counts.get("/pair"):
        return _pair(recording)
    if not recording.counts.get("/fast"):
        raise UserError(
            f"{recording.path}: holds no cycles (/fast) and no pair of input and output; "
            "`stillarm import` brings measured data in"
        )
    fast = recording.columns("/fast")
    in_order = rows_in_order(fast["time_s"], fast)
    fast = {name: values[in_order] for name, values in fast.items()}
    cycle_s = row_step_s(fast["time_s"], model.timing.cycle_s)
    hz = model.arm.modes[0].frequency_hz
    if cycle_s * hz > 1.0 / _LEAST_ROWS_A_PERIOD:
        raise UserError(
            f"{recording.path}: /fast: rows come every {cycle_s:g} s, too far apart for arm.modes[0].frequency_hz = "
            f"{hz:g}; record at least {_LEAST_ROWS_A_PERIOD} a period, or correct the model's frequency"
        )
    time, backward, gaps = _unrolled(fast["time_s"], cycle_s)
    origin = float(fast["time_s"][0])
    place = np.rint((time - time[0]) / cycle_s).astype(np.int64)
    n = int(place[-1]) + 1
    if n > 40 * len(time) + 100_000:
        raise UserError(
            f"{recording.path}: /fast: {len(time)} rows span {n * cycle_s:.0f} s, most of them {cycle_s:g} s apart; "
            "cut the recording where it was interrupted, and diagnose each part by itself"
        )

    def grid(values: Array) -> Array:
        out = np.full(n, nan)
        out[place] = values
        return out

    there = np.zeros(n, bool)
    there[place] = True

    def sent(values: Array) -> Array:
        """What the drive was sent: held where a row has none, between its neighbours' where the row itself is missing,
        as holding would leave the joint behind with every such row for good."""
        held = _held(grid(values))
        held[~there] = np.interp(np.flatnonzero(~there), np.flatnonzero(there), held[there])
        return held

    reference = sent(fast["joint_velocity_reference_rad_s"])
    command = sent(fast["joint_velocity_command_rad_s"])
    if np.isnan(command).all():
        command = reference
    position, velocity = grid(fast["joint_position_rad"]), grid(fast["joint_velocity_rad_s"])
    imposed = None
    if np.isnan(command).all():
        imposed = imposed_command(position, velocity, model.drive, cycle_s)
    return Measured(
        name=str(recording.path),
        cycle_s=cycle_s,
        origin_s=origin,
        command=command if imposed is None else imposed,
        reference=reference,
        acceleration=grid(fast["acceleration_m_s2"]),
        position=position,
        velocity=velocity,
        joint_age_s=np.nan_to_num(grid(fast["joint_age_s"])),
        deflection=grid(fast["deflection_m"]),
        frames=_frames(recording, origin, backward),
        force=np.empty(0),
        imposed=imposed is not None,
        backward=backward,
        gaps=() if _are_missed_deadlines(recording, gaps, cycle_s) else gaps,
    )


def _are_missed_deadlines(recording: Recording, gaps: tuple[ClockGap, ...], cycle_s: float) -> bool:
    """Whether the loop that recorded them says that it has missed as many cycles as are not there: no clock was set."""
    told = 0
    for topic in ("/link", "/loop"):
        if recording.counts.get(topic):
            told = max(told, int(np.max(recording.columns(topic)["deadline_misses"], initial=0)))
    return told > 0 and told >= round(sum(gap.extra_s for gap in gaps) / cycle_s)


def _unrolled(time: Array, cycle_s: float) -> tuple[Array, tuple[ClockGap, ...], tuple[ClockGap, ...]]:
    """Row times with steps back taken out; where they were, and where the clock jumped forward."""
    step = np.diff(time)
    usual = float(np.median(step)) if len(step) else cycle_s
    out = time.copy()
    backward, gaps = [], []
    scatter = std_about_median(step) if len(step) else 0.0
    early = (step <= 0.0) | (usual - step > OUTLYING * scatter)  # than stamps that scatter are anyhow
    for i in np.flatnonzero(early & (step < 0.25 * min(usual, cycle_s))):
        extra = float(step[i]) - usual
        out[i + 1 :] -= extra
        backward.append((i + 1, extra))
    for i in np.flatnonzero(step > usual + (_STEP_CYCLES - 0.5) * max(usual, cycle_s)):
        gaps.append((i + 1, float(step[i]) - usual))
    place = np.rint((out - out[0]) / cycle_s).astype(np.int64)
    return (
        out,
        tuple(ClockGap(int(place[i]), extra) for i, extra in backward),
        tuple(ClockGap(int(place[i]), extra) for i, extra in gaps),
    )


def _held(values: Array) -> Array:
    """Each missing value is the last one before it (the first ones: the first there is)."""
    known = np.flatnonzero(~np.isnan(values))
    if not len(known):
        return values
    place = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(len(values))))
    return values[np.where(place < 0, known[0], place)]


def _frames(recording: Recording, origin_s: float, backward: tuple[ClockGap, ...]) -> Frames:
    if not recording.counts.get("/frames"):
        empty = np.empty(0)
        return Frames(np.empty(0, np.int64), empty, empty, empty, empty)
    found = recording.columns("/frames")
    seen = np.isin(found["status"], (TrackingStatus.MEASURED,))
    displacement = np.where(seen, found["displacement_px"], nan)
    received, started = found["received_s"] - origin_s, found["started_s"] - origin_s
    if backward:  # frames' clock stepped back with the rows'
        step = np.diff(received)
        for i, gap in zip(
            np.flatnonzero(step < -0.5 * min(-gap.extra_s for gap in backward)), backward, strict=False
        ):
            received[i + 1 :] -= gap.extra_s
            started[i + 1 :] -= gap.extra_s
    return Frames(found["frame"].astype(np.int64), received, started, displacement, found["captured_s"])


def _pair(recording: Recording) -> Measured:
    found = recording.columns("/pair")
    rate = float(recording.header.notes["rate_hz"])
    n = len(found["input"])
    none = np.full(n, nan)
    empty = np.empty(0)
    frames = Frames(np.empty(0, np.int64), empty, empty, empty, empty)
    force = bridged(found["input"])
    if not len(force) or float(np.ptp(force)) == 0.0:
        raise UserError(
            f"{recording.path}: the input never changes, so that the output tells nothing of what it does; "
            "map another column to input"
        )
    return Measured(
        str(recording.path), 1.0 / rate, 0.0, np.zeros(n), np.zeros(n), none, none, none,
        np.zeros(n), found["output"], frames, force, pair=True,
    )  # fmt: skip


def rows_in_order(time_s: Array, columns: dict[str, Array]) -> Rows:
    """Indices of the rows to use, in their order in time: without rows that repeat the one before them, value for
    value; sorted by time where that puts each at an instant of its own."""
    rows = np.arange(len(time_s))
    again = np.zeros(len(time_s), bool)
    again[1:] = np.diff(time_s) == 0.0
    if again.any():
        for values in columns.values():
            if values.dtype.kind == "f":
                same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
                again[1:] &= same
        rows = rows[~again]
    step = np.diff(time_s[rows])
    if np.all(step > 0.0) or not len(step):
        return rows
    ordered = rows[np.argsort(time_s[rows], kind="stable")]
    usual = float(np.median(np.abs(step)))
    return ordered if float(np.min(np.diff(time_s[ordered]))) > REGULAR * usual else rows


def row_step_s(time_s: Array, cycle_s: float) -> float:
    """Time between the places of the grid, s: the model's cycle, unless rows plainly come at another rate. The mean of
    the regular steps, as times are often rounded; a whole number of cycles where it is one but for that."""
    step = np.diff(time_s)
    step = step[step > 0.0]
    if not len(step):
        return cycle_s
    usual = float(np.median(step))
    if 1.0 / _OTHER_RATE**2 < usual / cycle_s < _OTHER_RATE:
        return cycle_s
    regular = np.abs(step - usual) < REGULAR * usual
    if regular.mean() < _MOSTLY:
        return cycle_s
    mean_s = float(np.mean(step[regular]))
    cycles = round(mean_s / cycle_s)
    return cycles * cycle_s if cycles and abs(mean_s / cycle_s - cycles) < _WHOLE * cycles else mean_s


def imposed_command(position: Array, velocity: Array, drive: Drive, cycle_s: float) -> Array | None:
    """The command, rad/s, (n,), from the joint's velocity in rad/s or else its position in rad, (n,), NaN where
    unmeasured; None where neither was measured, or the joint stood still."""
    window = max(5, 2 * round(0.5 * WINDOW_S / cycle_s) + 1)
    by_velocity = np.isfinite(velocity).sum() >= np.isfinite(position).sum()
    measured = velocity if by_velocity else position
    known = np.flatnonzero(np.isfinite(measured))
    if len(known) <= window:
        return None
    values = measured[known]
    noise = std_about_zero(np.diff(values)) / 2.0**0.5
    filled = bridged(measured)
    level = savgol_filter(filled, window, 3)
    if float(np.ptp(level)) <= MIN_TRAVEL * noise:
        return None
    rate: Array = savgol_filter(filled, window, 3, deriv=1, delta=cycle_s)
    omega: Array = level if by_velocity else rate
    change: Array = rate if by_velocity else savgol_filter(filled, window, 3, deriv=2, delta=cycle_s)
    time = np.arange(len(measured)) * cycle_s
    due: Array = np.interp(time + drive.dead_time_s, time, omega + change / (2.0 * pi * drive.bandwidth_hz))
    return due
