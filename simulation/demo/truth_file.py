"""Reading a truth file for scoring. Replay and diagnosis never open one."""

from pathlib import Path

import numpy as np

from stillarm.common.recording.reader import open_recording
from stillarm.simulation.demo.scoring import Truth
from stillarm.simulation.recording.truth import STRIKE


def read_truth(path: Path, origin_monotonic_s: float) -> Truth:
    """The truth on the clock of a recording whose cycle 0 was at `origin_monotonic_s` of the rig's clock."""
    recording = open_recording(path)
    shift = recording.header.origin_monotonic_s - origin_monotonic_s
    state = recording.columns("/truth/state")
    frames = recording.columns("/truth/frames") if recording.counts.get("/truth/frames") else None
    log = recording.messages("/log") if recording.counts.get("/log") else iter(())
    return Truth(
        state["time_s"] + shift,
        state["deflection_m"],
        [line.time_s + shift for line in log if line.text.startswith(STRIKE)],
        {}
        if frames is None
        else dict(
            zip(frames["frame"].tolist(), np.add(frames["mid_exposure_s"], shift).tolist(), strict=True)
        ),
    )
