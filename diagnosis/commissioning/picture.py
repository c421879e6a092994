"""The picture of a commissioning: what was measured, what the fitted model says, and what is left."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from stillarm.diagnosis.commissioning.procedure import Commissioning

_MEASURED, _MODEL, _LEFT = "#8c8c8c", "#4c72b0", "#c44e52"
_STYLE: Any = {
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.size": 9,
}
_LABELS = {
    "joint_position": ("joint, mrad", 1e3),
    "displacement": ("image, px", 1.0),
    "acceleration": ("acceleration, m/s$^2$", 1.0),
}


def draw(done: Commissioning, path: Path) -> None:
    """Write the picture; its format by the file's ending (png, svg)."""
    world, predicted = done.found.fit.world, done.found.fit.predicted.channels
    shown = [name for name in _LABELS if name in world.channels]
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(9.0, 2.2 * len(shown) + 2.2), layout="constrained")
        rows = figure.subplots(len(shown) + 1, 1, squeeze=False)[:, 0]
        for axes, name in zip(rows[:-1], shown, strict=True):
            label, unit = _LABELS[name]
            time = world.instants(done.found.fit.vector) if name == "displacement" else world.cycle_times
            values = unit * world.channels[name]
            axes.plot(time, values, color=_MEASURED, linewidth=0.8, label="measured")
            axes.plot(time, unit * predicted[name], color=_MODEL, linewidth=0.8, label="model, free run")
            axes.plot(time, values - unit * predicted[name], color=_LEFT, linewidth=0.4, label="left")
            axes.set_ylabel(label)
        rows[0].legend(loc="upper right", ncols=3, frameon=False)
        rows[0].set_title(done.verdict.text, fontsize=9, loc="left", wrap=True)
        rows[-2].set_xlabel("time, s")
        _arrivals(rows[-1], done)
        figure.savefig(path, dpi=130)


def _arrivals(axes: Any, done: Commissioning) -> None:
    """How late each image was: the law of the capture delay."""
    fit = done.found.fit
    late = 1e3 * (done.measured.frames.received_s - fit.world.instants(fit.vector))
    axes.hist(late[np.isfinite(late)], bins=60, color=_MODEL)
    axes.set_xlabel("capture delay, ms")
    axes.set_ylabel("images")
