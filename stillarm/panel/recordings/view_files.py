"""Reduced images on disk: views.bin, one page's message after another, and index.npy, which says when each was newest.

index.npy: (3, n) float64: time, s on the drawn recording's clock, ascending; place in views.bin; length, bytes.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from stillarm.common.user_error import UserError

VIEWS, INDEX = "views.bin", "index.npy"


class RecordedView(NamedTuple):
    """message: for the page, as live. time_s, until_s: from when to when it is the newest one, s of the recording."""

    message: bytes
    time_s: float
    until_s: float


def write_index(folder: Path, rows: list[tuple[float, int, int]]) -> None:
    """Close a folder whose views.bin is complete. rows: time, place and length of each view, in any order."""
    np.save(folder / INDEX, np.array(sorted(rows), np.float64).reshape(-1, 3).T)


def has_views(folder: Path) -> bool:
    """Whether a folder is complete."""
    return (folder / INDEX).is_file()


def view_at(folder: Path, time_s: float) -> RecordedView:
    """The newest view at a time; the first one before that. Raises UserError where there is none."""
    if not has_views(folder):
        raise UserError("the images of this recording have not been read yet")
    times, places, lengths = np.load(folder / INDEX, mmap_mode="r")
    if len(times) == 0:
        raise UserError("the recording holds no image that can be drawn")
    newest = int(np.searchsorted(times, time_s, side="right")) - 1
    shown = max(0, newest)
    with (folder / VIEWS).open("rb") as file:
        file.seek(int(places[shown]))
        message = file.read(int(lengths[shown]))
    following = float(times[newest + 1]) if newest + 1 < len(times) else float("inf")
    return RecordedView(message, float(times[shown]), following)
