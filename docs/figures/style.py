"""How the figures look, and how one is written so that the same data give the same bytes."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

TRUTH, BLUE, RED, GREEN, ORANGE = "#333333", "#4c72b0", "#c44e52", "#55a868", "#dd8452"
_STYLE: Any = {
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.size": 9,
    "svg.hashsalt": "stillarm",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
}


def new_figure(rows: int = 1, height: float = 3.2, *, sharex: bool = False) -> tuple[Figure, list[Axes]]:
    """A figure of 7.5 inches' width with axes below each other."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(7.5, height), layout="constrained")
        axes = figure.subplots(rows, 1, squeeze=False, sharex=sharex)
    return figure, [row[0] for row in axes]


def new_pairs(rows: int, height: float) -> tuple[Figure, list[tuple[Axes, Axes]]]:
    """A figure of 7.5 inches' width with two axes side by side in each row."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(7.5, height), layout="constrained")
        axes = figure.subplots(rows, 2, squeeze=False)
    return figure, [(left, right) for left, right in axes]


def save(figure: Figure, path: Path) -> None:
    """Write as SVG, without a date."""
    with mpl.rc_context(_STYLE):
        figure.savefig(path, metadata={"Date": None})
