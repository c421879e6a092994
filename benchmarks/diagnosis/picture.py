"""Draws a campaign's pictures."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_campaign(result: dict[str, Any], folder: Path) -> None:
    """confusion.png; and, where causes were hidden, sizes.png."""
    draw_confusion(result["confusion"], folder / "confusion.png")
    if result["by_nats"]:
        draw_sizes(result["by_nats"], result["by_cause"], folder / "sizes.png")


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


def draw_sizes(by_nats: list[dict[str, Any]], by_cause: dict[str, dict[str, Any]], path: Path) -> None:
    """Rates of detection and naming against size, with Wilson's intervals, and the size from which 80 % are named."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 2.5 + 0.22 * len(by_cause)), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    _rates(left, by_nats)
    names = list(by_cause)
    for unit, marker in (("nats", "o"), ("over_noise", "s")):
        sizes = [by_cause[name][f"least_{unit}_80_percent"] for name in names]
        known = [(size, i) for i, size in enumerate(sizes) if size]
        shown = "nats" if unit == "nats" else "rms / noise rms in the strongest channel"
        right.plot([s for s, _ in known], [i for _, i in known], marker, label=shown)
    counts = [f"{name}  {by_cause[name]['named']}/{by_cause[name]['trials']}" for name in names]
    right.set_yticks(range(len(names)), counts, fontsize=8)
    if right.dataLim.x1 > 0.0:  # without any size there is no scale
        right.set_xscale("log")
    right.set_xlabel("size from which 80 % were named")
    right.grid(axis="x", alpha=0.3)
    right.legend(fontsize=8, loc="lower right")
    figure.savefig(path, dpi=130)


def _rates(axes: "Axes", by_nats: list[dict[str, Any]]) -> None:
    centres = [(row["from_nats"] * (row["to_nats"] or 2.0 * row["from_nats"])) ** 0.5 for row in by_nats]
    for name, shift in (("detected", 0.97), ("named", 1.03)):
        rates = np.array([row[name] / row["trials"] for row in by_nats])
        spans = np.array([row[f"{name}_interval"] for row in by_nats])
        away = np.maximum([rates - spans[:, 0], spans[:, 1] - rates], 0.0)
        axes.errorbar([shift * c for c in centres], rates, away, marker="o", capsize=3, label=name)
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.05)
    axes.set_xlabel("size, nats")
    axes.set_ylabel("fraction of trials")
    axes.grid(alpha=0.3)
    axes.legend()
