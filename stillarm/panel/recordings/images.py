"""The recorded images of a run as reduced views with their tracked points: `python -m ... REC FOLDER OUT`.

The supervisor records images in a file of its own (--record-images). REC is that file, or the controller's recording,
whose images are then looked for in the other recordings of FOLDER. OUT gets the files of view_files.py. The tracked
points are not recorded: the tracker runs again, exactly as it ran live.
"""

import sys
from collections import deque
from collections.abc import Callable, Iterator
from math import isnan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from stillarm.common.files.configuration import Configuration, default_configuration_path
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.recording.topics import ImageSample
from stillarm.common.user_error import UserError
from stillarm.panel.live.view import view_message
from stillarm.panel.recordings.view_files import VIEWS, write_index
from stillarm.supervisor.recorded_images import recorded_frame
from stillarm.supervisor.step import Supervisor
from stillarm.supervisor.view import view_datagram

_MOST_VIEWS = 20_000  # some 200 MB
_MOST_FILES = 50  # of the folder that are looked into, those of about the same time first
# a first image has displacement 0 in every run; three that differ from 0 agree in one run only
_FEWEST_MATCHES = 3
_TELL_EVERY = 50
_Key = tuple[int, float]


class _Found(NamedTuple):
    """recording: with the images. times_s: of each image on the clock of the recording that is drawn, by key."""

    recording: Recording
    times_s: dict[_Key, deque[float]] | None


def write_views(
    path: Path, siblings: list[Path], out: Path, stopped: Callable[[], bool] = lambda: False
) -> int:
    """Write OUT's files for the recording at `path`; how many views.

    siblings: where its images may lie. stopped: whether to leave the rest. Raises UserError where there are none, or
    the recording cannot be read.
    """
    found = _with_images(open_recording(path), siblings)
    header, name = found.recording.header, f"{found.recording.path} (configuration)"
    text = header.configuration or default_configuration_path().read_text()
    supervisor = Supervisor(parse_toml(text, Configuration, name).supervisor.tracker)
    count = found.recording.counts["/images"]
    every = -(-count // _MOST_VIEWS)
    out.mkdir(parents=True, exist_ok=True)
    rows: list[tuple[float, int, int]] = []
    with (out / VIEWS).open("wb") as file:
        for number, message in enumerate(found.recording.messages("/images")):
            if stopped():
                return 0
            view = _view(supervisor, message)
            time_s = _time_s(found, message)
            if view is not None and time_s is not None and number % every == 0:
                rows.append((time_s, file.tell(), len(view)))
                file.write(view)
            if number % _TELL_EVERY == 0:
                print(f"progress {number / count:.3f} images", file=sys.stderr, flush=True)
    write_index(out, rows)
    return len(rows)


def _with_images(recording: Recording, siblings: list[Path]) -> _Found:
    if recording.counts.get("/images"):
        return _Found(recording, None)
    if recording.counts.get("/frames"):
        for path in siblings:
            other = _open_quietly(path)
            if other is None or not other.counts.get("/images"):
                continue
            times_s = _read_times(recording)
            if _agree(other, times_s):
                return _Found(other, times_s)
    raise UserError(
        f"{recording.path.name}: no images of this run in the folder; "
        "`stillarm supervisor --record-images FILE` records them"
    )


def _open_quietly(path: Path) -> Recording | None:
    """A recording, or None for a file that is none."""
    try:
        return open_recording(path)
    except UserError:
        return None


def _read_times(recording: Recording) -> dict[_Key, deque[float]]:
    """When the controller read each sample, s on its clock."""
    times_s: dict[_Key, deque[float]] = {}
    for frame in recording.messages("/frames"):
        key = _key(frame.started_cycle, frame.displacement_px)
        times_s.setdefault(key, deque()).append(frame.received_s)
    return times_s


def _agree(other: Recording, times_s: dict[_Key, deque[float]]) -> bool:
    """Whether the images of `other` are those of the samples: by n_i and displacement, which no clock tells."""
    agreeing = 0
    for image in other.messages("/images"):
        key = _key(image.started_cycle, image.displacement_px)
        agreeing += key[1] != 0.0 and key in times_s
        if agreeing >= _FEWEST_MATCHES:
            return True
    return False


def _key(started_cycle: int, displacement_px: float) -> _Key:
    return started_cycle, 0.0 if isnan(displacement_px) else displacement_px


def _view(supervisor: Supervisor, message: ImageSample) -> bytes | None:
    """The page's message for an image; None where it cannot be made."""
    frame = recorded_frame(message)
    sample = supervisor.step(frame, message.started_cycle)
    points = supervisor.seen_points() if sample.measured else np.empty((0, 2), np.float32)
    datagram = view_datagram(frame.image, points, sample.frame)
    return None if datagram is None else view_message(datagram)


def _time_s(found: _Found, message: ImageSample) -> float | None:
    """Where on the drawn recording's clock the image belongs; None where the controller did not read its sample."""
    if found.times_s is None:
        return message.time_s
    waiting = found.times_s.get(_key(message.started_cycle, message.displacement_px))
    return waiting.popleft() if waiting else None


def nearest_siblings(path: Path, folder: Path) -> Iterator[Path]:
    """The other recordings of the folder, those first whose last change is nearest to this one's."""
    changed_s = path.stat().st_mtime
    others = [p for p in folder.glob("*.mcap") if p.is_file() and p.name != path.name]
    yield from sorted(others, key=lambda p: abs(p.stat().st_mtime - changed_s))[:_MOST_FILES]


def main(path: str, folder: str, out: str) -> int:
    """Run; returns the exit status."""
    stop = StopSignal()
    try:
        siblings = list(nearest_siblings(Path(path), Path(folder)))
        count = write_views(Path(path), siblings, Path(out), stop.is_set)
    except UserError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{count} images", flush=True)
    return int(stop.is_set())


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
