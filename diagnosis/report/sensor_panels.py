"""Single panels of the sensors and the drive: gains, limits, spikes, lateness, clocks. As panels.py."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from stillarm.diagnosis.data.frame_times import stamps_apart
from stillarm.diagnosis.data.robust import bridged, std_about_median
from stillarm.diagnosis.report.case import Case
from stillarm.diagnosis.report.drawing import (
    AFTER,
    BEFORE,
    INK,
    MEASURED,
    Draw,
    few,
    legend,
)
from stillarm.diagnosis.report.panels import axis_of
from stillarm.diagnosis.report.residuals import UNITS, WORDS, residual_of
from stillarm.diagnosis.report.views import (
    binned,
    lateness,
    sensitivity,
)

Array = NDArray[np.float64]


def measured_against_simulated(case: Case, name: str) -> Draw:
    """Measured against what the simulation without any limit says."""

    def draw(axes: Axes) -> None:
        measured = case.after.world.channels[name]
        for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after")):
            x, y, _ = binned(fit.predicted.channels[name], measured, 60, even=True)
            axes.plot(x, y, "o", ms=3, color=colour, label=word)
        reach = np.array(axes.get_xlim())
        axes.plot(reach, reach, color=INK, lw=0.6)
        axes.set_xlabel(f"simulated {axis_of(name)}")
        axes.set_ylabel("measured (median)")
        axes.set_title("measured against simulated")
        legend(axes)

    return draw


def speed_against_command(case: Case, name: str) -> Draw:
    """The joint's velocity, measured and simulated, in bins of its command."""

    def draw(axes: Axes) -> None:
        world = case.after.world
        command = np.nan_to_num(world.measured.command)
        steady = np.abs(np.convolve(np.diff(command, prepend=command[0]), np.ones(80), "same")) < 1e-9
        moving = (np.abs(command) > 1e-9) & steady
        moving = moving if moving.sum() > 500 else np.abs(command) > 1e-9

        def speed(values: Array) -> Array:
            if name == "joint_velocity":
                return values
            rate: Array = np.gradient(_smooth(values, 25)) / world.measured.cycle_s
            return rate

        shown = [(world.channels[name], MEASURED, "measured")]
        shown += [
            (fit.predicted.channels[name], colour, word)
            for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after"))
        ]
        for values, colour, word in shown:
            x, y, _ = binned(np.where(moving, command, np.nan), speed(values), 40, even=True)
            fmt = "o" if word == "measured" else ("s" if word.endswith("before") else "x")
            axes.plot(x, y, fmt, color=colour, ms=6 if fmt == "o" else 4, fillstyle="none", label=word)
        axes.set_xlabel("command, rad/s")
        axes.set_ylabel("joint velocity (median), rad/s")
        axes.set_title("joint velocity against its command")
        legend(axes)

    return draw


def _smooth(values: Array, width: int) -> Array:
    window = np.ones(width) / width
    smooth: Array = np.convolve(np.pad(bridged(values), width // 2, mode="edge"), window, "valid")[
        : len(values)
    ]
    return smooth


def image_lateness(case: Case, name: str) -> Draw:
    """By how much later the images were taken than the simulation has them, from their motion."""

    def draw(axes: Axes) -> None:
        origin = case.after.world.measured.origin_s
        for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after")):
            x, y, error = lateness(fit)
            axes.errorbar(x + origin, 1e3 * y, 1e3 * error, color=colour, fmt="o", ms=3.5, lw=0.8, label=word)
        axes.axhline(0.0, color=INK, lw=0.5)
        axes.set_xlabel("time, s")
        axes.set_ylabel("lateness, ms")
        axes.set_title("lateness of the images by their motion")
        legend(axes)

    return draw


def arrivals(case: Case, name: str) -> Draw:
    """By how much later the frames arrived than the simulation has them."""

    def draw(axes: Axes) -> None:
        origin = case.after.world.measured.origin_s
        fits = ((case.before, BEFORE, "before"), (case.after, AFTER, "after"))
        for fit, colour, word in fits:
            x, y = few(fit.world.times_of("arrival") + origin, 1e3 * residual_of(fit, "arrival"))
            axes.plot(x, y, ".", color=colour, ms=2.5, label=word)
        axes.set_xlabel("time, s")
        axes.set_ylabel("later than simulated, ms")
        axes.set_title("arrival of the frames")
        legend(axes)

    return draw


def gain_in_time(case: Case, name: str) -> Draw:
    """Size of the measured over the simulated channel."""

    def draw(axes: Axes) -> None:
        origin = case.after.world.measured.origin_s
        for fit, colour, word in ((case.before, BEFORE, "before"), (case.after, AFTER, "after")):
            x, y = sensitivity(fit, name)
            axes.plot(x + origin, y, "o-", color=colour, ms=3.5, lw=1.0, label=word)
        axes.axhline(1.0, color=INK, lw=0.5)
        axes.set_xlabel("time, s")
        axes.set_ylabel("measured / simulated")
        axes.set_title(f"size of the {WORDS[name]} over time")
        legend(axes)

    return draw


def histogram(case: Case, name: str) -> Draw:
    """How often residuals of a size occur, beside the normal law."""

    def draw(axes: Axes) -> None:
        residual = residual_of(case.after, name)
        values = residual[np.isfinite(residual)]
        core = std_about_median(values) or 1.0
        reach = float(np.max(np.abs(values)))
        counts, edges = np.histogram(values, bins=121, range=(-reach, reach))
        middle, width = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
        normal = len(values) * width * np.exp(-0.5 * (middle / core) ** 2) / (core * np.sqrt(2.0 * np.pi))
        axes.bar(middle, counts, width, color=AFTER, label="samples")
        shown = normal > 0.3
        axes.plot(middle[shown], normal[shown], color=BEFORE, ls="--", label="normal law")
        axes.set_yscale("log")
        axes.set_ylim(0.5, None)
        axes.set_xlabel(f"residual, {UNITS[name]}")
        axes.set_ylabel("samples")
        axes.set_title(f"{WORDS[name]}: how residuals scatter")
        legend(axes)

    return draw


def missing_frames(case: Case, name: str) -> Draw:
    """Frames that were exposed and never came, second by second."""

    def draw(axes: Axes) -> None:
        world = case.after.world
        received, counts = world.measured.frames.received_s, world.frame_clock.counts
        missing = np.clip(np.diff(counts, prepend=counts[0] - 1) - 1, 0, 30)
        second = received.astype(np.int64)
        per_second = np.bincount(np.clip(second, 0, None), missing)
        start = np.arange(len(per_second)) + world.measured.origin_s
        axes.bar(start, per_second, 0.9, align="edge", color=AFTER)
        axes.set_xlabel("time, s")
        axes.set_ylabel("frames missing in a second")
        axes.set_title(f"frames that never came ({world.model.camera.frame_rate_hz:g} exposed a second)")

    return draw


def stamp_offsets(case: Case, name: str) -> Draw:
    """The camera's stamps against the frames' own grid; where they are that grid, their step taken back, as they were
    against the controller's clock."""

    def draw(axes: Axes) -> None:
        world = case.after.world
        frames, clock = world.measured.frames, world.frame_clock
        off, other = frames.captured_s - clock.grid_s, "frame grid"
        apart = None if clock.counted else stamps_apart(frames)
        if apart is not None and case.finding is not None:
            onset_s, step_s = (case.finding.values[one][0] for one in ("onset_s", "step_s"))
            off, other = apart + np.where(frames.received_s >= onset_s, step_s, 0.0), "the controller's clock"
        x, y = few(frames.received_s + world.measured.origin_s, 1e3 * (off - np.nanmedian(off)))
        axes.plot(x, y, ".", color=AFTER, ms=3)
        axes.set_xlabel("time, s")
        axes.set_ylabel(f"stamp less {other}, ms")
        axes.set_title(f"the camera's clock against {'its own frames' if clock.counted else other}")

    return draw
