"""What a picture shows, as numbers: amplitude, frequency, lateness, gain, and the stretch that differs most."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import hann

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.report.residuals import residual_of

Array = NDArray[np.float64]
_STEP_S = 0.005
_PERIODS = 2.0
_LEAST_AMPLITUDE = 0.1


@dataclass(frozen=True)
class Swing:
    """Amplitude (in the channel's unit) and frequency, Hz, over time; frequency NaN where there is too little swing."""

    time_s: Array
    amplitude: Array
    frequency_hz: Array


def swing(time_s: Array, values: Array, frequency_hz: float) -> Swing:
    """Demodulation at a frequency over two of its periods (Hann window)."""
    known = np.isfinite(values) & np.isfinite(time_s)
    order = np.argsort(time_s[known])
    t, v = time_s[known][order], values[known][order]
    step = max(_STEP_S, float(np.median(np.diff(t)))) if frequency_hz < 10.0 else float(np.median(np.diff(t)))
    grid = np.arange(t[0], t[-1], step)
    if step > 2.0 * float(np.median(np.diff(t))):  # means of what lies between, against aliases
        place = np.clip(((t - t[0]) / step + 0.5).astype(np.int64), 0, len(grid) - 1)
        count = np.bincount(place, minlength=len(grid))
        mean = np.bincount(place, v, len(grid)) / np.maximum(count, 1)
        filled = np.interp(grid, grid[count > 0], mean[count > 0])
    else:
        filled = np.interp(grid, t, v)
    # a recording shorter than the window has no middle, and shows nothing
    window = hann(min(max(5, round(_PERIODS / frequency_hz / step)), len(filled)), sym=True)
    window = window / (window.sum() or 1.0)
    level = np.convolve(filled, window, "same") / np.convolve(np.ones(len(filled)), window, "same")
    turned = (filled - level) * np.exp(-2j * pi * frequency_hz * grid)
    phasor = np.convolve(turned, window, "same")
    amplitude = 2.0 * np.abs(phasor)
    phase = np.unwrap(np.angle(phasor))
    frequency = frequency_hz + np.gradient(phase, step) / (2.0 * pi)
    edge = len(window)
    amplitude[:edge] = np.nan
    amplitude[-edge:] = np.nan
    little = ~(amplitude > _LEAST_AMPLITUDE * np.nanmax(amplitude, initial=0.0))
    return Swing(grid, amplitude, np.where(little, np.nan, frequency))


def binned(x: Array, y: Array, bins: int, *, even: bool = False) -> tuple[Array, Array, Array]:
    """Median of x and of y, and the median's standard error, in bins of equal counts (or equal widths)."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) < 4 * bins or float(np.ptp(x)) <= 0.0:
        return np.empty(0), np.empty(0), np.empty(0)
    edges = (
        np.linspace(x.min(), x.max(), bins + 1)
        if even
        else np.unique(np.quantile(x, np.linspace(0.0, 1.0, bins + 1)))
    )
    place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    rows = [(x[place == k], y[place == k]) for k in range(len(edges) - 1)]
    rows = [row for row in rows if len(row[0]) >= 4]
    spread = [1.2533 * float(np.std(b)) / np.sqrt(len(b)) for _, b in rows]
    return (
        np.array([float(np.median(a)) for a, _ in rows]),
        np.array([float(np.median(b)) for _, b in rows]),
        np.array(spread),
    )


def lateness(fit: Fit, span_s: float = 0.5) -> tuple[Array, Array, Array]:
    """By how much later the images are than the fit has them, from their motion: time, lateness, deviation; all s.

    Regression of the residual on the image's speed over stretches of span_s; stretches without motion are left out.
    """
    images = fit.channel("displacement")
    if images is None:
        return np.empty(0), np.empty(0), np.empty(0)
    residual, rate = residual_of(fit, "displacement"), fit.predicted.rate_px_s
    time = fit.world.times_of("displacement")
    known = np.isfinite(residual) & np.isfinite(rate)
    place = (time[known] / span_s).astype(np.int64)
    size = int(place.max()) + 1 if len(place) else 1
    power = np.bincount(place, rate[known] ** 2, size)
    product = np.bincount(place, rate[known] * residual[known], size)
    enough = power > 1e-2 * power.max()
    late = -product[enough] / power[enough]
    std = images.sigma / np.sqrt(power[enough])
    return (np.arange(size)[enough] + 0.5) * span_s, late, std


def sensitivity(fit: Fit, name: str, span_s: float = 1.0) -> tuple[Array, Array]:
    """Size of the measured channel over the simulated one, over stretches of span_s."""
    values, predicted = fit.world.channels[name], fit.predicted.channels[name]
    time = fit.world.times_of(name)
    known = np.isfinite(values)
    place = (time[known] / span_s).astype(np.int64)
    size = int(place.max()) + 1
    power = np.bincount(place, predicted[known] ** 2, size)
    product = np.bincount(place, predicted[known] * values[known], size)
    enough = power > 0.02 * power.max()
    return (np.arange(size)[enough] + 0.5) * span_s, product[enough] / power[enough]


def telling_stretch(before: Fit, after: Fit, name: str, split: Split, length_s: float) -> tuple[float, float]:
    """The stretch, s, in which the two fits differ most, its middle in a held-out block where there is one."""
    time = after.world.times_of(name)
    measured = after.world.channels[name]
    gain = np.nan_to_num(
        (measured - before.predicted.channels[name]) ** 2 - (measured - after.predicted.channels[name]) ** 2
    )
    step = max(_STEP_S, after.world.measured.duration_s / 20000.0)
    place = np.clip((np.nan_to_num(time) / step).astype(np.int64), 0, None)
    per_step = np.bincount(place, gain)
    width = max(1, round(length_s / step))
    total = np.convolve(per_step, np.ones(width), "same")
    known = np.isfinite(measured)
    count, first, second = (
        np.convolve(np.bincount(place[known], weight, len(per_step)), np.ones(width), "same")
        for weight in (np.ones(known.sum()), measured[known], measured[known] ** 2)
    )
    # beside the variation within the stretch, which sets the picture's scale
    total = total / np.maximum(
        second - first**2 / np.maximum(count, 1.0), 1e-6 * float(second.max()) + 1e-300
    )
    middle: Array = np.arange(len(total), dtype=np.float64) * step
    held = split.held[split.blocks_of(middle)]
    if held.any():
        total = np.where(held, total, -np.inf)
    at = float(middle[int(np.argmax(total))])
    start = min(max(at - 0.5 * length_s, 0.0), max(after.world.measured.duration_s - length_s, 0.0))
    return start, start + length_s


def ringing_freely(fit: Fit, time_s: Array) -> NDArray[np.bool_]:
    """Whether neither the joint moved nor an impact fell within a period of the arm."""
    world = fit.world
    period = 1.0 / arm_frequency(fit)
    busy = np.abs(np.nan_to_num(world.measured.command)) > 1e-4
    busy[list(world.impacts)] = True
    many = np.concatenate(([0], np.cumsum(busy)))
    reach = round(period / world.measured.cycle_s)
    at = np.round(time_s / world.measured.cycle_s).astype(np.int64)
    low, high = (np.clip(at + side * reach, 0, len(busy)) for side in (-1, 1))
    free: NDArray[np.bool_] = many[high] == many[low]
    return free


def arm_frequency(fit: Fit) -> float:
    """Of the first mode, Hz."""
    return fit.value("modes.0.frequency_hz")


def sample_times(fit: Fit, name: str) -> Array:
    """When each sample was true: of an image its mid-exposure, of all else when it was read."""
    if name == "displacement":
        return fit.world.instants(fit.vector)
    return fit.world.times_of(name)
