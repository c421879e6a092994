"""What is left of the damping when the deflection is predicted for the wrong time."""

from pathlib import Path

import numpy as np
from style import BLUE, GREEN, ORANGE, RED, new_figure, save


def draw(path: Path) -> None:
    """docs/images/phase.svg: cos(w e), the part of the added damping that an error e of the delay leaves."""
    error_s = np.linspace(0.0, 0.2, 400)
    figure, (axes,) = new_figure()
    for frequency_hz, colour in ((1.0, GREEN), (2.6, BLUE), (6.0, ORANGE)):
        axes.plot(
            1e3 * error_s,
            np.cos(2 * np.pi * frequency_hz * error_s),
            color=colour,
            label=f"{frequency_hz:g} Hz",
        )
    axes.axvline(74.0, color=RED, linestyle="--")
    axes.annotate(" an image taken\n for the present", (74.0, 0.72), color=RED)
    axes.axhspan(-1.05, 0.0, color=RED, alpha=0.08)
    axes.annotate("damping drives the arm", (196, -0.93), color=RED, ha="right")
    axes.set(
        xlabel="error of the delay, ms",
        ylabel="share of the added damping",
        xlim=(0, 200),
        ylim=(-1.05, 1.05),
    )
    axes.legend(loc="upper right")
    save(figure, path)
