"""`fused` on the demo's run: the deflection with its band, and the delay of each frame beside the truth."""

from pathlib import Path

import numpy as np
from runs import demo_run
from style import GREEN, RED, TRUTH, new_figure, save

import stillarm

FROM_S, TO_S = 1.5, 8.0  # the part of the run that is drawn: the strike at 2 s, and some periods


def draw(path: Path) -> None:
    """docs/images/fused.svg"""
    run = demo_run()
    said = stillarm.replay(run.recording.path, "fused")["fused"]
    shown = (said.estimates["time_s"] > FROM_S) & (said.estimates["time_s"] < TO_S)
    time_s, q, std = (
        said.estimates[name][shown][::10] for name in ("time_s", "deflection_m", "deflection_std_m")
    )
    state, true = run.truth["truth_state"], run.truth["truth_frames"]
    figure, (above, below) = new_figure(2, 4.8)
    error = q - np.interp(time_s, state["time_s"], state["deflection_m"])
    above.fill_between(time_s, -2e3 * std, 2e3 * std, color=GREEN, alpha=0.3, label="two stated deviations")
    above.plot(time_s, 1e3 * error, color=GREEN, linewidth=0.6, label="error of the present deflection")
    above.set(xlim=(FROM_S, TO_S), ylim=(-1.2, 1.2), ylabel="mm", xlabel="time, s")
    above.legend(loc="upper right", ncols=2)
    part = (said.frames["received_s"] > FROM_S) & (said.frames["received_s"] < TO_S)
    delay_s, dstd = said.frames["delay_s"][part], said.frames["delay_std_s"][part]
    received = said.frames["received_s"][part]
    truly = received - np.interp(said.frames["frame"][part], true["frame"], true["mid_exposure_s"])
    below.fill_between(
        received, 1e3 * (delay_s - 2 * dstd), 1e3 * (delay_s + 2 * dstd), color=GREEN, alpha=0.3
    )
    below.plot(received, 1e3 * truly, ".", color=TRUTH, markersize=3, label="true delay of each frame")
    below.plot(received, 1e3 * delay_s, color=GREEN, label="estimated")
    below.axhline(
        1e3 * run.recording.model.timing.capture_delay_s, color=RED, linestyle=":", label="the model's mean"
    )
    below.set(xlim=(FROM_S, TO_S), ylim=(55, 95), ylabel="capture delay, ms", xlabel="time, s")
    below.legend(loc="lower right", ncols=3)
    save(figure, path)
