"""The demo's figures, after the paper's Fig. 4 to 7, and an overview."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stillarm.controller.estimation.delay.correlation import CorrelationDelay
from stillarm.controller.estimation.estimate import Observation
from stillarm.controller.estimation.methods import make_method
from stillarm.controller.estimation.sine_method import SineMethod
from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.replay.replay import MethodRun, RecordedRun
from stillarm.simulation.demo.scoring import Truth, scored_span_s, struck_amplitude_m

_COLOURS = {"timestamps": "#c44e52", "correlation": "#4c72b0", "fused": "#55a868"}
_TRUTH = "#333333"
_STYLE: Any = {
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.size": 9,
}


def draw_figures(
    directory: Path, run: RecordedRun, truth: Truth, replays: list[MethodRun], summary: dict[str, Any]
) -> None:
    """Write overview.png and fig4_signals.png to fig7_methods.png."""
    with mpl.rc_context(_STYLE):
        _overview(truth, run, summary).savefig(directory / "overview.png", dpi=130)
        _signals(run, truth, replays).savefig(directory / "fig4_signals.png", dpi=130)
        _correlation(run, truth).savefig(directory / "fig5_correlation.png", dpi=130)
        _delays(run, truth, replays).savefig(directory / "fig6_delay.png", dpi=130)
        _methods(run, truth, replays).savefig(directory / "fig7_methods.png", dpi=130)


def _figure(rows: int, height: float) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(8.0, height), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)
    return figure, [row[0] for row in axes]


def _overview(truth: Truth, run: RecordedRun, summary: dict[str, Any]) -> Figure:
    figure, (deflection, command) = _figure(2, 4.6)
    damping = summary["damping"]
    free = damping["settling_time_free_s"] or damping["settling_time_free_fitted_s"]
    settled = damping["settling_time_damped_s"]
    deflection.plot(truth.time_s, 1e3 * truth.deflection_m, color=_TRUTH, linewidth=0.6)
    deflection.set_ylabel("tip deflection, mm")
    if free and settled:
        deflection.set_title(
            f"Struck twice: free, it would settle in {free:.1f} s; damped through the late camera, in {settled:.1f} s",
            fontsize=10,
        )
    command.plot(
        [row.time_s for row in run.fast],
        [1e3 * row.joint_velocity_command_rad_s for row in run.fast],
        color=_COLOURS["correlation"],
        linewidth=0.6,
    )
    command.set_ylabel("joint command, mrad/s")
    command.set_xlabel("time, s")
    for axes in (deflection, command):
        for strike, label in zip(truth.strikes_s, ("struck", "struck, damping on"), strict=False):
            axes.axvline(strike, color="#dd8452", linewidth=1.0, linestyle="--")
            if axes is deflection:
                axes.annotate(
                    label, (strike, 0.97), xycoords=("data", "axes fraction"), xytext=(4, 0),
                    textcoords="offset points", va="top", color="#dd8452",
                )  # fmt: skip
    command.set_xlim(0.0, float(run.fast[-1].time_s))
    return figure


def _signals(run: RecordedRun, truth: Truth, replays: list[MethodRun]) -> Figure:
    """After Fig. 4: accelerometer, image, predicted oscillation, each by its amplitude."""
    mode = run.model.arm.modes[0]
    from_s, to_s = truth.strikes_s[0] + 1.0, truth.strikes_s[0] + 4.0
    amplitude = struck_amplitude_m(truth, truth.strikes_s[0], mode.frequency_hz)
    camera, scale = run.model.camera, run.model.accelerometer.scale
    figure, axes = _figure(3, 6.0)
    fast = [row for row in run.fast if from_s <= row.time_s < to_s]
    of_full = mode.angular_frequency**2 * amplitude * scale
    axes[0].plot(
        [r.time_s for r in fast],
        [-r.acceleration_m_s2 / of_full for r in fast],
        color="#8c8c8c",
        linewidth=0.5,
    )
    axes[0].set_ylabel("accelerometer\n(- a / w² A)")
    frames = [f for f in run.frames if from_s <= f.received_s < to_s]
    seen = np.array([f.displacement_px for f in frames])
    axes[1].plot(
        [f.received_s for f in frames],
        -(seen - np.nanmean(seen)) / camera.scale_px_per_m / amplitude,
        color=_COLOURS["correlation"],
        marker=".",
        linewidth=0.8,
    )
    axes[1].set_ylabel("image, as received\n(- d / scale A)")
    best = next(r for r in replays if r.method == "correlation")
    times = np.array(best.times_s)
    inside = (times >= from_s) & (times < to_s)
    predicted = np.array([e.deflection_m for e in best.estimates])[inside] / amplitude
    true = np.interp(times[inside], truth.time_s, truth.deflection_m) / amplitude
    axes[2].plot(times[inside], true, color=_TRUTH, linewidth=2.5, alpha=0.3, label="truth")
    axes[2].plot(times[inside], predicted, color=_COLOURS["correlation"], linewidth=1.0, label="predicted")
    received = np.array([f.received_s for f in frames])
    axes[2].plot(
        received,
        np.interp(received, times[inside], predicted),
        "x",
        color=_COLOURS["correlation"],
        markersize=3,
        label="image read",
    )
    axes[2].set_ylabel("prediction / A")
    axes[2].set_xlabel("time, s")
    axes[2].legend(loc="upper right", ncols=3, fontsize=8)
    axes[0].set_title("Noisy but punctual; clean but late; clean and punctual", fontsize=10)
    return figure


def _correlation(run: RecordedRun, truth: Truth) -> Figure:
    """After Fig. 5: correlation against lag while the arm rings."""
    at_s = truth.strikes_s[0] + 3.0
    method = make_method("correlation", run.model, run.configuration.controller, run.name)
    assert isinstance(method, SineMethod) and isinstance(method.delay, CorrelationDelay)
    joint = JointMotion(run.model, run.model.arm.length_m or 1.0)
    for read, command, *_ in run.cycles():
        time_s = read.cycle * run.cycle_s
        if time_s > at_s:
            break
        joint.begin_cycle(read.cycle, read.joint_position_rad)
        method.update(Observation(read.cycle, time_s, read.acceleration_m_s2, read.samples, joint))
        joint.send(command)
    figure, (axes,) = _figure(1, 3.6)
    axes.plot(1e3 * method.delay.lags_s, method.delay.correlation, color=_COLOURS["correlation"])
    found = method.delay.estimate
    axes.axvline(1e3 * found.delay_s, color=_COLOURS["timestamps"], linestyle="--", linewidth=1.0)
    axes.set_title(
        f"Correlation at t = {at_s:.1f} s: delay {1e3 * found.delay_s:.1f} ± {1e3 * found.std_s:.1f} ms",
        fontsize=10,
    )
    axes.set_xlabel("capture delay, ms")
    axes.set_ylabel("correlation coefficient")
    return figure


def _delays(run: RecordedRun, truth: Truth, replays: list[MethodRun]) -> Figure:
    """After Fig. 6: the estimated capture delay over time, with the truth; below, the error beside what was stated."""
    figure, (axes, below) = _figure(2, 5.6)
    _delay_errors(below, truth, replays[-1])
    true = [
        (f.received_s, f.received_s - truth.mid_exposure_s[f.frame])
        for f in run.frames
        if f.frame in truth.mid_exposure_s
    ]
    axes.plot(
        [t for t, _ in true],
        [1e3 * d for _, d in true],
        ".",
        color=_TRUTH,
        markersize=2.5,
        zorder=3,
        label="truth",
    )
    for replay in replays:
        times = [t for _, t, _ in replay.frames]
        delays = np.array([1e3 * delay.delay_s for _, _, delay in replay.frames])
        stds = np.array([1e3 * delay.std_s for _, _, delay in replay.frames])
        colour = _COLOURS[replay.method]
        axes.plot(times, delays, color=colour, linewidth=0.9, label=replay.method)
        axes.fill_between(times, delays - stds, delays + stds, color=colour, alpha=0.2, linewidth=0)
    for strike in truth.strikes_s:
        axes.axvline(strike, color="#dd8452", linewidth=1.0, linestyle="--")
    low, high = np.percentile([1e3 * d for _, d in true], [0.5, 99.5]) if true else (40.0, 110.0)
    axes.set_ylim(min(40.0, low - 5.0), max(110.0, high + 5.0))
    below.set_xlabel("time, s")
    axes.set_ylabel("capture delay, ms")
    axes.legend(loc="upper right", ncols=3, fontsize=8)
    axes.set_title(
        "Capture delay: what each method says (band: its stated standard deviation), and what it was",
        fontsize=10,
    )
    return figure


def _delay_errors(axes: Axes, truth: Truth, replay: MethodRun) -> None:
    """Each frame's error of one method, over a band of twice its stated standard deviation."""
    known = [
        (received, delay.delay_s - (received - truth.mid_exposure_s[frame]), delay.std_s)
        for frame, received, delay in replay.frames
        if frame in truth.mid_exposure_s
    ]
    seconds, error_s, std_s = np.array(known, dtype=np.float64).reshape(-1, 3).T
    errors, band, colour = 1e3 * error_s, 2e3 * std_s, _COLOURS[replay.method]
    axes.fill_between(
        seconds, -band, band, color=colour, alpha=0.3, linewidth=0, label="± 2 stated deviations"
    )
    axes.plot(seconds, errors, ".", color=_TRUTH, markersize=2.0, label=f"error of {replay.method}")
    shown = np.abs(np.concatenate((band, errors)))
    shown = shown[np.isfinite(shown)]
    if len(shown):
        limit = 1.3 * float(np.percentile(shown, 98.0))
        axes.set_ylim(-limit, limit)
    axes.set_ylabel("stated - true, ms")
    axes.legend(loc="upper right", ncols=2, fontsize=8)


def _methods(run: RecordedRun, truth: Truth, replays: list[MethodRun]) -> Figure:
    """After Fig. 7: both methods' predictions, and their errors."""
    frequency = run.model.arm.modes[0].frequency_hz
    from_s, to_s = scored_span_s(truth, frequency)
    from_s += 1.0
    to_s = min(to_s, from_s + 4.0)
    amplitude = struck_amplitude_m(truth, truth.strikes_s[0], frequency)
    figure, (prediction, error) = _figure(2, 5.0)
    times = np.array(replays[0].times_s)
    inside = (times >= from_s) & (times < to_s)
    true = np.interp(times[inside], truth.time_s, truth.deflection_m) / amplitude
    prediction.plot(times[inside], true, color=_TRUTH, linewidth=2.5, alpha=0.3, label="truth")
    for replay in replays:
        said = np.array([e.deflection_m for e in replay.estimates])[inside] / amplitude
        prediction.plot(
            times[inside], said, color=_COLOURS[replay.method], linewidth=0.9, label=replay.method
        )
        difference = 100.0 * (said - true)
        mean = float(np.mean(np.abs(difference)))
        error.plot(
            times[inside],
            difference,
            color=_COLOURS[replay.method],
            linewidth=0.8,
            label=f"{replay.method}: mean {mean:.1f} %",
        )
    prediction.set_ylabel("deflection / A")
    prediction.legend(loc="upper right", ncols=3, fontsize=8)
    prediction.set_title("Predicted deflection and its error, in % of the struck amplitude", fontsize=10)
    error.set_ylabel("error, %")
    error.set_xlabel("time, s")
    error.legend(loc="upper right", ncols=2, fontsize=8)
    return figure
