"""The recordings of one folder: the list, and each one's columns, replay and diagnosis in a cache of its own."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.panel.live.packing import MOST_ROWS, packed
from stillarm.panel.recordings.decimation import min_max
from stillarm.panel.recordings.jobs import Jobs
from stillarm.panel.recordings.view_files import RecordedView, has_views, view_at
from stillarm.panel.server.paths import confined

SUFFIXES = (".mcap",)
_MOST_LISTED = 500
_MOST_INTERVALS = MOST_ROWS // 2


class Library:
    """A folder of recordings, and a cache. A recording that was opened is known by a key from then on.

    A file that has grown since has another key; its drawing stays as it was opened.
    """

    def __init__(self, folder: Path, cache: Path) -> None:
        """folder: of the recordings; cache: a folder of the panel's own; its maker removes it."""
        self._folder, self._cache = folder, cache
        self._jobs = Jobs()
        self._opened: dict[str, Path] = {}

    def listed(self) -> list[dict[str, Any]]:
        """Name, size in bytes and time of change (s, Unix) of each recording, the newest first."""
        found = []
        for path in self._folder.iterdir():
            if confined(self._folder, path.name, SUFFIXES) is not None:
                status = path.stat()
                found.append((status.st_mtime, path.name, status.st_size))
        newest = sorted(found, reverse=True)[:_MOST_LISTED]
        return [{"name": name, "bytes": size, "changed_s": changed_s} for changed_s, name, size in newest]

    async def open(self, name: str) -> str:
        """The key of a recording of the folder as it is now; reads it where that has not been done.

        Raises UserError where there is no such recording, or it cannot be read.
        """
        path = confined(self._folder, name, SUFFIXES)
        if path is None:
            raise UserError("no such recording in the panel's folder; open the list again")
        status = path.stat()
        text = f"{path.name} {status.st_size} {status.st_mtime_ns}"
        key = hashlib.sha256(text.encode()).hexdigest()[:24]
        cache = self._cache / key
        if not (cache / "about.json").exists():
            what = f"read {name}"
            job = self._jobs.get(what)
            if job is None or not job.running:
                job = await self._jobs.start(
                    what, str(path), str(cache), module="stillarm.panel.recordings.extract"
                )
            if not await job.ended():
                lines = job.told()["lines"]
                raise UserError(lines[-1] if lines else f"{name}: cannot be read")
        self._opened[key] = path
        return key

    def _path(self, key: str) -> Path:
        """The file that was opened under a key. Raises UserError for another key."""
        if key not in self._opened:
            raise UserError("this recording is not open; open it from the list again")
        return self._opened[key]

    def about(self, key: str) -> dict[str, Any]:
        """Content of an opened recording, and the jobs done on it. Raises UserError."""
        self._path(key)
        cache = self._cache / key
        told: dict[str, Any] = json.loads((cache / "about.json").read_text())
        methods = cache / "replay" / "methods.json"
        told["key"] = key
        told["methods"] = json.loads(methods.read_text()) if methods.exists() else []
        told["images"] = has_views(cache / "images")
        told["diagnosed"] = (cache / "diagnosis" / "report.html").exists()
        return told

    def series(self, key: str, topic: str, from_s: float, to_s: float, intervals: int) -> bytes:
        """A topic's columns between two times as one packed message of kind 0; no peak is lost. Raises UserError.

        topic: one of `about`'s topics, or replay_METHOD.
        """
        self._path(key)
        folder = self._cache / key / ("replay" if topic.startswith("replay_") else "")
        file = confined(folder, f"{topic}.npy", (".npy",)) if folder.is_dir() else None
        if file is None:
            raise UserError(f"the recording has no {topic[:40]!r}; open it again")
        rows = np.load(file, mmap_mode="r")
        begin, end = np.searchsorted(rows[0], (from_s, to_s), side="left")
        cut = np.asarray(rows[:, begin:end])
        times, columns = min_max(cut[0], cut[1:], min(max(intervals, 1), _MOST_INTERVALS))
        return packed(0, times.tolist(), [column.tolist() for column in columns])

    def view(self, key: str, time_s: float) -> RecordedView:
        """The newest image at a time of the recording; the first one before that. Raises UserError."""
        self._path(key)
        return view_at(self._cache / key / "images", time_s)

    async def start(self, what: str, key: str) -> None:
        """Start `replay` (with all methods), `diagnose` or `images`. Raises UserError."""
        path = str(self._path(key))
        cache = self._cache / key
        words, module = {
            "replay": ([path, str(cache / "replay")], "stillarm.panel.recordings.replay_all"),
            "diagnose": (["diagnose", path, "--out", str(cache / "diagnosis")], "stillarm"),
            "images": ([path, str(self._folder), str(cache / "images")], "stillarm.panel.recordings.images"),
        }[what]
        job = self._jobs.get(f"{what} {key}")
        if what == "images" and job is not None and job.running:
            return  # another page has asked for the same
        await self._jobs.start(f"{what} {key}", *words, module=module)

    def job(self, what: str, key: str) -> dict[str, Any] | None:
        """The state of a started job; None where none was started."""
        job = self._jobs.get(f"{what} {key}")
        return None if job is None else job.told()

    def report(self, key: str) -> str:
        """The diagnosis' report, a page of its own. Raises UserError where there is none."""
        self._path(key)
        path = self._cache / key / "diagnosis" / "report.html"
        if not path.is_file():
            raise UserError("this recording has not been diagnosed yet")
        return path.read_text(encoding="utf-8")

    async def close(self) -> None:
        """Stop what runs."""
        await self._jobs.stop_all()
