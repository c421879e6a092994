"""What a demo's rig truly did, read off its truth file, and where the arm swings."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError

Values = NDArray[np.float64]

_STEP_S = 0.002  # of the even grid on which amplitudes are taken: 190 steps a period at 2.6 Hz


@dataclass(frozen=True)
class Swing:
    """A vibration from the strike that began it, on the controller's clock, s."""

    begin_s: float
    end_s: float


@dataclass(frozen=True)
class TrueRun:
    """time_s, deflection_m: shape (steps,), evenly spaced. mid_exposure_s: by frame. On the controller's clock."""

    time_s: Values
    deflection_m: Values
    mid_exposure_s: dict[int, float]
    swings: tuple[Swing, ...]


def read_truth(truth: Path, recording: Path, damping_on_s: float) -> TrueRun:
    """Read a demo's truth on the clock of its recording. The first swing ends where the damping is switched on, at
    `damping_on_s`; the second with the run. Raises UserError for a rig that was struck less than twice.
    """
    strikes, true = read_strikes_and_motion(truth, recording)
    if len(strikes) < 2:
        raise UserError(f"{truth}: the rig was struck {len(strikes)} times, not twice; see rig.log beside it")
    end_s = float(true.time_s[-1])
    return replace(true, swings=(Swing(strikes[0], min(damping_on_s, strikes[1])), Swing(strikes[1], end_s)))


def read_strikes_and_motion(truth: Path, recording: Path) -> tuple[list[float], TrueRun]:
    """When the rig was struck, s, and what it did, without swings; both on the clock of the recording."""
    file = open_recording(truth)
    header = open_recording(recording).header
    shift = file.header.origin_monotonic_s - header.origin_monotonic_s
    state = file.columns("/truth/state")
    time_s = np.asarray(state["time_s"]) + shift
    even = np.arange(time_s[0], time_s[-1], _STEP_S)
    strikes = (
        [line.time_s + shift for line in file.messages("/log") if line.text.startswith("strike")]
        if file.counts.get("/log")
        else []
    )
    frames = file.columns("/truth/frames")
    mid = zip(frames["frame"].tolist(), (np.asarray(frames["mid_exposure_s"]) + shift).tolist(), strict=True)
    return strikes, TrueRun(even, np.interp(even, time_s, state["deflection_m"]), dict(mid), ())
