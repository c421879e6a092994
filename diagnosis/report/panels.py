"""Single panels: each takes a case and returns what draws it on one pair of axes."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.report.case import Case
from stillarm.diagnosis.report.dependence import variables
from stillarm.diagnosis.report.drawing import (
    AFTER,
    BEFORE,
    FLOOR,
    INK,
    MEASURED,
    SHADE,
    Draw,
    few,
    legend,
    outline,
)
from stillarm.diagnosis.report.residuals import UNITS, WORDS, residual_of, spectrum_of
from stillarm.diagnosis.report.views import (
    arm_frequency,
    binned,
    ringing_freely,
    sample_times,
    swing,
    telling_stretch,
)

Array = NDArray[np.float64]

_FREE_SHARE = 0.2


def axis_of(name: str) -> str:
    """A channel's name with its unit."""
    return f"{WORDS[name]}, {UNITS[name]}"


def overlay(case: Case, name: str) -> Draw:
    """Measured and simulated over the held-out stretch in which the two simulations differ most."""
    length = min(4.0 / arm_frequency(case.after), case.after.world.measured.duration_s)
    start, end = telling_stretch(case.before, case.after, name, case.split, length)
    origin = case.after.world.measured.origin_s

    def draw(axes: Axes) -> None:
        fits: tuple[tuple[Fit, str, str], ...] = (
            (case.before, BEFORE, "before"),
            (case.after, AFTER, "after"),
        )
        time = sample_times(case.after, name)
        inside = (time >= start) & (time <= end)
        dense = inside.sum() > 400
        x, y = few(time[inside] + origin, case.after.world.channels[name][inside])
        axes.plot(x, y, ".", color=MEASURED, ms=1.6 if dense else 3.5, label="measured")
        for fit, colour, word in fits:
            time = sample_times(fit, name)
            inside = (time >= start) & (time <= end)
            order = np.argsort(time[inside])
            x, y = few(time[inside][order] + origin, fit.predicted.channels[name][inside][order])
            axes.plot(x, y, color=colour, ls="--" if word == "before" else "-", label=word)
        axes.set_xlabel("time, s")
        axes.set_ylabel(axis_of(name))
        axes.set_title("where the simulations differ most (held out)")
        legend(axes)

    return draw


def residual_in_time(case: Case, name: str) -> Draw:
    """Residual over the whole recording."""

    def draw(axes: Axes) -> None:
        origin = case.after.world.measured.origin_s
        for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after")):
            x, low, high = outline(fit.world.times_of(name) + origin, residual_of(fit, name))
            axes.fill_between(x, low, high, color=colour, lw=0.4, alpha=0.75, label=word)
        for start, end in _held_spans(case):
            axes.axvspan(start + origin, end + origin, color=SHADE, lw=0, zorder=-1)
        axes.set_xlabel("time, s (shaded: held out)")
        axes.set_ylabel(f"residual, {UNITS[name]}")
        axes.set_title(f"{WORDS[name]}: measured less simulated")
        legend(axes)

    return draw


def _held_spans(case: Case) -> list[tuple[float, float]]:
    edges, held = case.split.edges_s, case.split.held
    return [(float(edges[k]), float(edges[k + 1])) for k in range(len(held)) if held[k]]


def residual_spectrum(case: Case, name: str, band_hz: tuple[float, float] | None = None) -> Draw:
    """Spectrum of the residual, on the level of the noise."""

    def draw(axes: Axes) -> None:
        for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after")):
            spectrum = spectrum_of(residual_of(fit, name), fit.world.step_s(name))
            axes.loglog(*few(spectrum.hz, np.sqrt(spectrum.density)), color=colour, lw=1.0, label=word)
        floor = spectrum_of(residual_of(case.after, name), case.after.world.step_s(name)).floor
        if floor > 0.0:
            axes.axhline(float(np.sqrt(floor)), color=FLOOR, ls=":", label="noise floor")
        if band_hz:
            axes.axvspan(*band_hz, color=SHADE, lw=0, zorder=-1)
        axes.set_xlabel("frequency, Hz" + (" (shaded: what is left)" if band_hz else ""))
        axes.set_ylabel(f"{UNITS[name]} / √Hz")
        axes.set_title(f"{WORDS[name]}: spectrum of the residual")
        legend(axes)

    return draw


def residual_against(case: Case, name: str, variable: str) -> Draw:
    """Mean residual in bins of a variable."""

    def draw(axes: Axes) -> None:
        unit = ""
        for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after")):
            values, unit = variables(fit, name)[variable]
            x, y, error = binned(values, residual_of(fit, name), 15)
            axes.errorbar(x, y, 2.0 * error, color=colour, fmt="o-", ms=3.5, lw=1.0, label=word)
        axes.axhline(0.0, color=INK, lw=0.5)
        axes.set_xlabel(f"{variable}, {unit}" if unit else variable)
        axes.set_ylabel(f"median residual, {UNITS[name]}")
        axes.set_title(f"{WORDS[name]}: residual against {variable}")
        legend(axes)

    return draw


def _swings(case: Case, name: str) -> list[tuple[Array, Array, Array, str, str]]:
    """Time, amplitude and frequency of the measured channel and of both simulations, with colour and word.

    NaN while the joint moves, where the arm rings freely for a fifth of the time or more.
    """
    f = arm_frequency(case.after)
    series = (
        (sample_times(case.after, name), case.after.world.channels[name], MEASURED, "measured"),
        (sample_times(case.before, name), case.before.predicted.channels[name], BEFORE, "before"),
        (sample_times(case.after, name), case.after.predicted.channels[name], AFTER, "after"),
    )
    found = []
    for time, values, colour, word in series:
        one = swing(time, values, f)
        free = ringing_freely(case.after, one.time_s)
        amplitude, frequency = one.amplitude, one.frequency_hz
        if free.mean() > _FREE_SHARE:
            amplitude, frequency = np.where(free, amplitude, np.nan), np.where(free, frequency, np.nan)
        found.append((one.time_s, amplitude, frequency, colour, word))
    return found


def frequency_against_amplitude(case: Case, name: str) -> Draw:
    """Frequency of the swing in bins of its amplitude."""

    def draw(axes: Axes) -> None:
        for _, amplitude, frequency, colour, word in _swings(case, name):
            x, y, error = binned(np.where(np.isfinite(frequency), amplitude, np.nan), frequency, 12)
            fmt = "o" if word == "measured" else ("--" if word.endswith("before") else "-")
            axes.errorbar(x, y, error if fmt == "o" else None, color=colour, fmt=fmt, ms=4, label=word)
        axes.set_xlabel(f"amplitude, {UNITS[name]}")
        axes.set_ylabel("frequency, Hz")
        axes.set_title("frequency against amplitude")
        legend(axes)

    return draw


def frequency_in_time(case: Case, name: str) -> Draw:
    """Frequency of the swing over time."""

    def draw(axes: Axes) -> None:
        origin = case.after.world.measured.origin_s
        for time, _, frequency, colour, word in _swings(case, name):
            bins = max(8, min(40, int(time[-1])))
            x, y, _ = binned(np.where(np.isfinite(frequency), time, np.nan), frequency, bins, even=True)
            fmt = "o" if word == "measured" else ("--" if word.endswith("before") else "-")
            axes.plot(x + origin, y, fmt, color=colour, ms=4, label=word)
        axes.set_xlabel("time, s")
        axes.set_ylabel("frequency, Hz")
        axes.set_title("frequency of the swing over time")
        legend(axes)

    return draw


def amplitude_in_time(case: Case, name: str) -> Draw:
    """Amplitude of the swing over time, logarithmic."""

    def draw(axes: Axes) -> None:
        origin = case.after.world.measured.origin_s
        for time, amplitude, _, colour, word in _swings(case, name):
            style = {"measured": "-", "before": "--", "after": "-"}[word]
            width = 3.0 if word == "measured" else 1.2
            axes.semilogy(*few(time + origin, amplitude), style, color=colour, lw=width, label=word)
        axes.set_xlabel("time, s")
        axes.set_ylabel(f"amplitude, {UNITS[name]}")
        axes.set_title("amplitude of the swing over time")
        legend(axes)

    return draw
