"""The live benchmark's picture: each run a dot; errors, honesty, settling, and what was missed."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stillarm.common.files.output_folder import make_folder

_LIVE_COLOUR, _OTHER_COLOUR, _FLOOR_COLOUR = "#55a868", "#4c72b0", "#8c8c8c"
_STYLE: Any = {"axes.grid": True, "grid.alpha": 0.3, "axes.spines.top": False, "axes.spines.right": False}
_LEAST = 1e-3  # where a logarithmic axis begins
_SPREAD = 0.25  # of the dots of one method, so that they do not hide each other


def draw(result: dict[str, Any], directory: Path) -> Path:
    """Write live.png into `directory`; returns where it is."""
    rows = result["rows"]
    make_folder(directory)
    with mpl.rc_context(_STYLE | {"font.size": 9}):
        figure = Figure(figsize=(10.0, 7.0), layout="constrained")
        (error, honesty), (beyond, missed) = figure.subplots(2, 2)
        runs = len({row["run"] for row in rows})
        figure.suptitle(
            f"{runs} demos in real time, {result['load']} busy processes beside them; a dot is a run"
        )
        _dots(error, rows, "error_mean", "mean error, % of the local amplitude", 100.0, log=True)
        _dots(
            honesty,
            rows,
            "deflection_normalised_error_squared_max",
            "normalised error squared, worst 5 s",
            log=True,
        )
        honesty.axhline(1.0, color=_FLOOR_COLOUR, linewidth=1.0)
        _dots(beyond, rows, "longest_beyond_2_std_s", "longest time beyond 2 std, s", log=False)
        beyond.axhline(0.5, color=_FLOOR_COLOUR, linewidth=1.0, linestyle="--")
        _misses(missed, rows)
        path = directory / "live.png"
        figure.savefig(path, dpi=130)
    return path


def _dots(
    axes: Axes, rows: list[dict[str, Any]], key: str, label: str, unit: float = 1.0, *, log: bool
) -> None:
    methods = list(dict.fromkeys(row["method"] for row in rows))
    for place, method in enumerate(methods):
        values = np.array(
            [unit * row[key] for row in rows if row["method"] == method and row[key] is not None]
        )
        values = np.maximum(values, _LEAST) if log else values
        across = (
            place + _SPREAD * np.linspace(-1.0, 1.0, len(values)) if len(values) > 1 else np.full(1, place)
        )
        colour = _LIVE_COLOUR if method == "fused" else _OTHER_COLOUR
        axes.plot(across[: len(values)], values, "o", color=colour, markersize=4, alpha=0.7)
        if len(values):
            axes.hlines(np.median(values), place - 0.4, place + 0.4, color=colour, linewidth=2.0)
    axes.set_xticks(range(len(methods)), [name.replace("_", "\n") for name in methods], fontsize=8)
    axes.set_ylabel(label)
    if log:
        axes.set_yscale("log")


def _misses(axes: Axes, rows: list[dict[str, Any]]) -> None:
    shared = list({row["run"]: row for row in rows}.values())
    runs = np.array([row["run"] for row in shared])
    for shift, key, label, colour in (
        (-0.27, "deadline_misses", "deadlines missed", _OTHER_COLOUR),
        (0.0, "floor_deadline_misses", "by the bare timer", _FLOOR_COLOUR),
        (0.27, "frames_lost", "frames lost", "#c44e52"),
    ):
        axes.bar(runs + shift, [row[key] for row in shared], width=0.25, color=colour, label=label)
    axes.set_ylim(0.0, max(1.0, axes.get_ylim()[1]))
    axes.set_xlabel("run")
    axes.set_xticks(runs)
    axes.legend(fontsize=8)
