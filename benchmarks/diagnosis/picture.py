"""Draws a campaign's pictures."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_campaign(result: dict[str, Any], folder: Path) -> None:
    """confusion.png; and, where causes were hidden, sizes.png."""
    draw_confusion(result["confusion"], folder / "confusion.png")
    if result["by_size"]:
        draw_sizes(result, folder / "sizes.png")


def draw_confusion(confusion: dict[str, dict[str, int]], path: Path) -> None:
    """Rows: what was hidden; columns: the first answer."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = list(confusion)
    answers = {answer for counts in confusion.values() for answer in counts}
    columns = [name for name in rows if name in answers] + sorted(answers - set(rows))
    table = np.array([[confusion[row].get(column, 0) for column in columns] for row in rows], dtype=float)
    share = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0)
    figure = Figure(figsize=(3.5 + 0.32 * len(columns), 2.5 + 0.28 * len(rows)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_xlabel("answered first")
    axes.set_ylabel("hidden")
    for i, j in np.argwhere(table > 0):
        colour = "white" if share[i, j] > 0.6 else "black"
        axes.text(j, i, f"{table[i, j]:.0f}", ha="center", va="center", fontsize=8, color=colour)
    figure.savefig(path, dpi=130)


def draw_sizes(result: dict[str, Any], path: Path) -> None:
    """Rates of detection and naming against size, with Wilson's intervals, beside the size at which an oracle is sure;
    and the size from which 80 % are named."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    by_cause = result["by_cause"]
    figure = Figure(figsize=(11.0, 2.5 + 0.22 * len(by_cause)), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    _rates(left, result["by_size"], result["oracle"])
    names = list(by_cause)
    known = [(size, i) for i, name in enumerate(names) if (size := by_cause[name]["least_size_80_percent"])]
    right.plot([size for size, _ in known], [i for _, i in known], "o")
    counts = [f"{name}  {by_cause[name]['named']}/{by_cause[name]['trials']}" for name in names]
    right.set_yticks(range(len(names)), counts, fontsize=8)
    if known:  # without any size there is no scale
        right.set_xscale("log")
    right.set_xlabel("size from which 80 % were named, times the noise")
    right.grid(axis="x", alpha=0.3)
    figure.savefig(path, dpi=130)


def _rates(axes: "Axes", by_size: list[dict[str, Any]], oracle: dict[str, Any]) -> None:
    centres = [_centre(row) for row in by_size]
    for name, shift in (("detected", 0.97), ("named", 1.03)):
        rates = np.array([row[name] / row["trials"] for row in by_size])
        spans = np.array([row[f"{name}_interval"] for row in by_size])
        away = np.maximum([rates - spans[:, 0], spans[:, 1] - rates], 0.0)
        axes.errorbar([shift * c for c in centres], rates, away, marker="o", capsize=3, label=name)
    if oracle["trials"]:
        words = f"an oracle's {oracle['nats']:g} nats, median"
        axes.axvline(oracle["size_in_noise_median"], color="0.5", linestyle="--", label=words)
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.05)
    axes.set_xlabel("size, times the noise")
    axes.set_ylabel("fraction of trials")
    axes.grid(alpha=0.3)
    axes.legend()


def _centre(row: dict[str, Any]) -> float:
    """Geometric mean of a bin's bounds; of one that is open, a decade."""
    low, high = row["from_size"], row["to_size"]
    return float(((low or 0.1 * high) * (high or 10.0 * low)) ** 0.5)
