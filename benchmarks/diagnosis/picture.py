"""The confusion matrix as a picture."""

from pathlib import Path

import numpy as np


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
