"""Figures as inline SVG whose colours are the page's, so that they follow dark mode and paper."""

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter
from numpy.typing import NDArray

Array = NDArray[np.float64]

INK, MEASURED, BEFORE, AFTER, FLOOR, SHADE = (
    "#1c1f23",
    "#8a9099",
    "#c8601a",
    "#1f67b0",
    "#2c8a57",
    "#e6e6e3",
)
"""The page's colours in daylight; `svg` turns them into its variables, so that no other line may have one of them."""

_VARIABLES = {
    INK: "--ink",
    MEASURED: "--measured",
    BEFORE: "--before",
    AFTER: "--after",
    FLOOR: "--floor",
    SHADE: "--shade",
}
_STYLE: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "stillarm",
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "axes.formatter.limits": (-3, 4),
    "path.simplify_threshold": 0.5,
}
_MOST_POINTS = 1500
_MARGINS_IN = (0.75, 0.12, 0.78, 0.3)  # left, right, bottom, top of each panel

Draw = Callable[[Axes], None]


@dataclass(frozen=True)
class Picture:
    """One row of panels. label: what a reader who cannot see it is told; panel_in: width and height of each, inches."""

    panels: Sequence[Draw]
    label: str
    panel_in: tuple[float, float] = (4.6, 2.9)


def figure(picture: Picture) -> Figure:
    """The picture as a figure of its own, which belongs to no window."""
    with rc_context(_STYLE):
        width, height = picture.panel_in[0] * len(picture.panels), picture.panel_in[1]
        drawn = Figure(figsize=(width, height))
        for place, draw in enumerate(picture.panels):
            left, right, bottom, top = _MARGINS_IN
            inner = (picture.panel_in[0] - left - right, height - bottom - top)
            corner = ((place * picture.panel_in[0] + left) / width, bottom / height)
            one = drawn.add_axes((*corner, inner[0] / width, inner[1] / height))
            draw(one)
            one.yaxis.set_offset_position(
                "right"
            )  # a factor such as 1e-3 at the left lifts the title out of the panel
            for axis in (one.xaxis, one.yaxis):
                if axis.get_scale() == "log":  # as plain numbers: powers of ten are slow to typeset
                    axis.set_major_formatter(LogFormatter())
                    axis.set_minor_formatter(LogFormatter(minor_thresholds=(1.2, 0.6)))
    return drawn


def svg(picture: Picture) -> str:
    """The picture as a part of the page."""
    drawn = figure(picture)
    for patch in (drawn.patch, *(one.patch for one in drawn.axes)):
        patch.set_alpha(0.0)
    out = io.StringIO()
    with rc_context(_STYLE):
        FigureCanvasSVG(drawn)
        drawn.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    return _embedded(out.getvalue(), picture.label)


_numbers = count()


def _embedded(text: str, label: str) -> str:
    """Without the file's head; ids of its own, colours by variable."""
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S)
    for stand_in, variable in _VARIABLES.items():
        text = text.replace(stand_in, f"var({variable})")
    mark = f"f{next(_numbers)}-"
    text = re.sub(r'\bid="', f'id="{mark}', text)
    text = re.sub(r'href="#', f'href="#{mark}', text)
    text = re.sub(r"url\(#", f"url(#{mark}", text)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    return text.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)


def few(*arrays: Array) -> tuple[Array, ...]:
    """The same arrays with at most so many points as a line needs."""
    step = max(1, -(-len(arrays[0]) // _MOST_POINTS))
    return tuple(one[::step] for one in arrays)


def outline(time: Array, values: Array, columns: int = 500) -> tuple[Array, Array, Array]:
    """A long series as its least and largest value in each of so many stretches."""
    known = np.isfinite(values)
    time, values = time[known], values[known]
    size = max(1, len(values) // columns)
    n = len(values) // size * size
    pieces = values[:n].reshape(-1, size)
    return time[:n].reshape(-1, size).mean(axis=1), pieces.min(axis=1), pieces.max(axis=1)


def legend(axes: Axes) -> None:
    """A legend out of the lines' way."""
    axes.legend(
        loc="upper left",
        bbox_to_anchor=(-0.02, -0.24),
        ncols=4,
        fontsize=8.5,
        handlelength=1.3,
        columnspacing=1.1,
    )
