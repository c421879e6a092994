"""The recordings of one folder: the list, and each one's columns, replay and diagnosis in a cache of its own."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.common.user_error import UserError
from stillarm.panel.live.packing import MOST_ROWS, packed
from stillarm.panel.recordings.decimation import min_max
from stillarm.panel.recordings.jobs import Job, Jobs
from stillarm.panel.server.paths import confined

SUFFIXES = (".mcap",)
_MOST_LISTED = 500
_MOST_INTERVALS = MOST_ROWS // 2


class Library:
    """A folder of recordings, and a cache beside nothing of the user's."""

    def __init__(self, folder: Path, cache: Path) -> None:
        """folder: of the recordings; cache: a folder that is the panel's own, removed by whoever made it."""
        self._folder, self._cache = folder, cache
        self._jobs = Jobs()

    def listed(self) -> list[dict[str, Any]]:
        """Name, size in bytes and time of change (s, Unix) of each recording, the newest first."""
        found = []
        for path in self._folder.iterdir():
            if confined(self._folder, path.name, SUFFIXES) is not None:
                status = path.stat()
                found.append((status.st_mtime, path.name, status.st_size))
        newest = sorted(found, reverse=True)[:_MOST_LISTED]
        return [{"name": name, "bytes": size, "changed_s": changed_s} for changed_s, name, size in newest]

    def path(self, name: str) -> Path:
        """The recording's file. Raises UserError where the folder holds no such recording."""
        path = confined(self._folder, name, SUFFIXES)
        if path is None:
            raise UserError("no such recording in the panel's folder; open the list again")
        return path

    def cache_of(self, name: str) -> Path:
        """The cache of a recording as it is now: a changed file has another one."""
        path = self.path(name)
        status = path.stat()
        key = f"{path.name} {status.st_size} {status.st_mtime_ns}"
        return self._cache / hashlib.sha256(key.encode()).hexdigest()[:24]

    async def about(self, name: str) -> dict[str, Any]:
        """What a recording holds; reads it first where that has not been done. Raises UserError."""
        cache = self.cache_of(name)
        about = cache / "about.json"
        if not about.exists():
            job = self._jobs.get(f"read {name}")
            if job is None or not job.running:
                job = await self._jobs.start(
                    f"read {name}",
                    *(str(self.path(name)), str(cache)),
                    module="stillarm.panel.recordings.extract",
                )
            if not await job.ended():
                lines = job.told()["lines"]
                raise UserError(lines[-1] if lines else f"{name}: cannot be read")
        told: dict[str, Any] = json.loads(about.read_text())
        methods = cache / "replay" / "methods.json"
        told["methods"] = json.loads(methods.read_text()) if methods.exists() else []
        told["diagnosed"] = (cache / "diagnosis" / "report.html").exists()
        return told

    def series(self, name: str, topic: str, from_s: float, to_s: float, intervals: int) -> bytes:
        """A topic's columns between two times as one packed message of kind 0; no peak is lost. Raises UserError.

        topic: one of `about`'s topics, or replay_METHOD.
        """
        cache = self.cache_of(name)
        folder = cache / "replay" if topic.startswith("replay_") else cache
        file = confined(folder, f"{topic}.npy", (".npy",)) if folder.is_dir() else None
        if file is None:
            raise UserError(f"{name}: no such data; open the recording again")
        rows = np.load(file, mmap_mode="r")
        begin, end = np.searchsorted(rows[0], (from_s, to_s), side="left")
        cut = np.asarray(rows[:, begin:end])
        times, columns = min_max(cut[0], cut[1:], min(max(intervals, 1), _MOST_INTERVALS))
        return packed(0, times.tolist(), [column.tolist() for column in columns])

    async def replay(self, name: str) -> Job:
        """Start a replay with all methods. Raises UserError."""
        out = self.cache_of(name) / "replay"
        return await self._jobs.start(
            f"replay {name}", str(self.path(name)), str(out), module="stillarm.panel.recordings.replay_all"
        )

    async def diagnose(self, name: str) -> Job:
        """Start a diagnosis. Raises UserError."""
        out = self.cache_of(name) / "diagnosis"
        return await self._jobs.start(f"diagnose {name}", "diagnose", str(self.path(name)), "--out", str(out))

    def job(self, what: str, name: str) -> dict[str, Any] | None:
        """The state of `WHAT NAME`; None where none was started."""
        job = self._jobs.get(f"{what} {name}")
        return None if job is None else job.told()

    def report(self, name: str) -> str:
        """The diagnosis' report, a page of its own. Raises UserError where there is none."""
        path = self.cache_of(name) / "diagnosis" / "report.html"
        if not path.is_file():
            raise UserError(f"{name}: not diagnosed yet")
        return path.read_text(encoding="utf-8")

    async def close(self) -> None:
        """Stop what runs."""
        await self._jobs.stop_all()
