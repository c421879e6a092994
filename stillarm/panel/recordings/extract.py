"""A recording as columns on disk, which the panel maps instead of reading: `python -m ... REC FOLDER`.

FOLDER gets TOPIC.npy for each topic that the page draws (float64, a row for each column, time_s first) and about.json.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.user_error import UserError
from stillarm.panel.live.packing import FRAME_COLUMNS, KINDS

_MOST_CHANGES = 1000
_MOST_LINES = 200


def extract(path: Path, folder: Path) -> None:
    """Write FOLDER's files for the recording at `path`. Raises UserError where that is none."""
    recording = open_recording(path)
    folder.mkdir(parents=True, exist_ok=True)
    topics: dict[str, list[str]] = {}
    about: dict[str, Any] = {"name": path.name, "cut": recording.cut, "changes": [], "lines": []}
    begin, end = np.inf, -np.inf
    for topic, names in KINDS:
        if not recording.counts.get(f"/{topic}"):
            continue
        columns = recording.columns(f"/{topic}")
        times = np.asarray(columns["time_s"], np.float64)
        rows = np.stack([times, *(np.asarray(columns[name], np.float64) for name in names)])
        np.save(folder / f"{topic}.npy", rows)
        topics[topic] = list(names)
        begin, end = min(begin, float(times[0])), max(end, float(times[-1]))
        if topic == "estimate":
            about["changes"] = _changes(times, columns["state"], columns["reason"])
    if not topics and recording.counts.get("/images"):
        rows = _tracked(recording)
        np.save(folder / "frames.npy", rows)
        topics["frames"] = list(FRAME_COLUMNS)
        begin, end = float(rows[0, 0]), float(rows[0, -1])
    if not topics:
        raise UserError(
            f"{path}: nothing that the page could draw; it needs /fast, /estimate, /frames or /images"
        )
    about["lines"] = _log_lines(recording)
    header = recording.header
    about |= {"topics": topics, "begin_s": begin, "end_s": end, "method": header.method, "kind": header.kind}
    about["program_version"] = header.program_version
    (folder / "about.json").write_text(json.dumps(about))


def _tracked(recording: Recording) -> NDArray[np.float64]:
    """The rows of /frames that the supervisor's own recording holds beside its images, one image in memory."""
    found = [
        (image.time_s, image.displacement_px, image.features, image.inliers, image.status)
        for image in recording.messages("/images")
    ]
    return np.array(found, np.float64).T


def _changes(times: Any, states: Any, reasons: Any) -> list[list[Any]]:
    """[time_s, state, reason] at each change."""
    found: list[list[Any]] = []
    for time_s, state, reason in zip(times, states, reasons, strict=True):
        if not found or found[-1][1:] != [state, reason]:
            found.append([float(time_s), state, reason])
    return found[:_MOST_CHANGES]


def _log_lines(recording: Recording) -> list[dict[str, Any]]:
    if not recording.counts.get("/log"):
        return []
    lines = [{"time_s": m.time_s, "level": m.level, "text": m.text} for m in recording.messages("/log")]
    return lines[:_MOST_LINES]


def main(path: str, folder: str) -> int:
    """Run; returns the exit status."""
    StopSignal()
    try:
        extract(Path(path), Path(folder))
    except UserError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
