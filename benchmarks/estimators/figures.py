"""Draws the pictures: the paper's Fig. 7 for every method, and errors against noise with the bound."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.benchmarks.estimators.trial import assumed_model, run_method, scored_cycles
from stillarm.benchmarks.estimators.world.generator import generate
from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, NOISES, REGIMES, Arm

_FROM_S, _TO_S = 4.0, 9.0
_SHOWN_REGIME, _SHOWN_NOISE = "freerun drift", 0.3
_MARKERS = "osv^DP*X<>"


def draw_predictions(methods: Sequence[str], seed: int, path: Path) -> None:
    """The paper's Fig. 7: prediction and truth, and below it their difference, on the same trial for each method."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    regime = REGIMES[_SHOWN_REGIME]
    data = generate(regime, _SHOWN_NOISE, (seed, 0, list(REGIMES).index(regime.name)), _TO_S, Arm())
    shown = slice(round(_FROM_S / CYCLE_S), None)
    time_s = np.arange(len(data.deflection_m))[shown] * CYCLE_S
    unit = data.arm.amplitude_m
    scored = scored_cycles(data)[shown]
    truth = data.deflection_m[shown] / unit
    figure = Figure(figsize=(11.0, 0.8 + 2.4 * len(methods)), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(
        f"{_SHOWN_REGIME}, accelerometer noise {_SHOWN_NOISE} of the amplitude (impacts: dotted)", fontsize=11
    )
    panels = figure.subplots(
        2 * len(methods), 1, sharex=True, squeeze=False, height_ratios=[1.6, 1.0] * len(methods)
    )[:, 0]
    for index, name in enumerate(methods):
        over, below = panels[2 * index], panels[2 * index + 1]
        for panel in (over, below):
            panel.margins(x=0.0)
            for impact in data.motion.impacts_s[
                (data.motion.impacts_s > _FROM_S) & (data.motion.impacts_s < _TO_S)
            ]:
                panel.axvline(impact, color="0.4", lw=0.8, ls=":")
        over.plot(time_s, truth, color="0.55", lw=2.5, label="truth")
        try:
            predicted = run_method(name, data, assumed_model(regime, _SHOWN_NOISE)).deflection_m[shown] / unit
        except Exception as failure:  # the other methods must still be drawn
            over.set_title(f"{name}: {failure}", fontsize=9, loc="left")
            continue
        over.plot(time_s, predicted, color="tab:blue", lw=1.0, label="prediction")
        over.set_ylim(-1.6, 1.6)
        error = 100.0 * (predicted - truth)
        mean = np.nanmean(np.abs(error[scored]))
        over.set_title(f"{name}: mean error {mean:.2f} % away from impacts", fontsize=9, loc="left")
        over.set_ylabel("q / amplitude", fontsize=8)
        below.plot(time_s, error, color="tab:red", lw=0.8)
        reach = max(1.0, float(np.nanpercentile(np.abs(error), 95.0)) * 1.5)
        below.set_ylim(-reach, reach)
        below.set_ylabel("error, %", fontsize=8)
        below.grid(alpha=0.3)
    panels[0].legend(loc="upper right", fontsize=8, ncols=2)
    panels[-1].set_xlabel("time, s")
    figure.savefig(path, dpi=110)


def draw_errors_against_noise(
    rows: Sequence[dict[str, Any]], figure_name: str, bound_name: str, label: str, path: Path
) -> None:
    """One panel for each regime: every method against the accelerometer's noise, and the bound as a dashed line."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    regimes = list(dict.fromkeys(row["regime"] for row in rows))
    methods = list(dict.fromkeys(row["method"] for row in rows))
    across = min(3, len(regimes))
    down = -(-len(regimes) // across)
    figure = Figure(figsize=(1.5 + 3.3 * across, 1.1 + 2.7 * down), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for place, regime in enumerate(regimes):
        panel = panels[place // across, place % across]
        for index, name in enumerate(methods):
            points = [
                (row["noise"], row[figure_name])
                for row in rows
                if row["regime"] == regime and row["method"] == name and row[figure_name] is not None
            ]
            if points:
                panel.loglog(
                    *zip(*points, strict=True),
                    marker=_MARKERS[index % len(_MARKERS)],
                    ms=4,
                    lw=1.2,
                    label=name,
                )
        limit = {row["noise"]: row[bound_name] for row in rows if row["regime"] == regime}
        panel.loglog(
            list(limit), list(limit.values()), color="black", ls="--", lw=1.2, marker="_", label="bound"
        )
        panel.set_title(regime, fontsize=9)
        panel.set_xticks(NOISES, [f"{noise:g}" for noise in NOISES])
        panel.minorticks_off()
        panel.grid(alpha=0.3)
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=min(4, len(names)), fontsize=8)
    figure.supxlabel("accelerometer noise / amplitude", fontsize=9)
    figure.supylabel(label, fontsize=9)
    figure.savefig(path, dpi=110)
