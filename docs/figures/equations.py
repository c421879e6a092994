"""Eq. 11: the correlation of images and accelerometer over the lag between them peaks at the capture delay."""

from pathlib import Path

import numpy as np
from runs import demo_run
from style import BLUE, ORANGE, TRUTH, new_figure, save


def draw(path: Path) -> None:
    """docs/images/equations.svg"""
    run = demo_run()
    fast, frames, model = run.recording.fast, run.recording.frames, run.recording.model
    w = model.arm.modes[0].angular_frequency
    fresh = (frames["received_s"] > 3.0) & (frames["received_s"] < 4.0)
    cycle = np.round(frames["received_s"][fresh] / model.timing.cycle_s).astype(int)
    images = -frames["displacement_px"][fresh] / model.camera.scale_px_per_m
    from_accelerometer = -fast["acceleration_m_s2"] / w**2
    lags = np.arange(-60, 220)
    correlation = [np.corrcoef(images, from_accelerometer[cycle - lag])[0, 1] for lag in lags]
    true = run.truth["truth_frames"]
    exposed = np.interp(frames["frame"][fresh], true["frame"], true["mid_exposure_s"])
    delay = np.median(frames["received_s"][fresh] - exposed)
    figure, (above, below) = new_figure(2, 4.6)
    time_s = fast["time_s"]
    above.plot(
        time_s, 1e3 * from_accelerometer, color=ORANGE, linewidth=0.5, label="accelerometer, as a deflection"
    )
    above.plot(
        frames["received_s"],
        -1e3 * frames["displacement_px"] / model.camera.scale_px_per_m,
        ".",
        color=BLUE,
        label="images",
    )
    above.set(xlim=(3.0, 4.0), ylim=(-14, 14), ylabel="mm", xlabel="time, s")
    above.legend(loc="upper right", ncols=2)
    below.plot(lags, correlation, color=TRUTH)
    below.axvline(1e3 * delay, color=BLUE, linestyle="--", label="true delay, median of these frames")
    below.set(xlabel="lag m, cycles of 1 ms", ylabel="C(m)")
    below.legend(loc="lower left")
    save(figure, path)
