"""What the images show, at the time at which the controller reads them, beside the deflection at that time."""

from pathlib import Path

from runs import demo_run
from style import BLUE, TRUTH, new_figure, save


def draw(path: Path) -> None:
    """docs/images/late-images.svg"""
    run = demo_run()
    state, frames = run.truth["truth_state"], run.recording.frames
    scale = run.recording.model.camera.scale_px_per_m
    zero = frames["displacement_px"][frames["received_s"] < 1.9].mean()
    shown = -(frames["displacement_px"] - zero) / scale
    figure, (axes,) = new_figure()
    axes.plot(state["time_s"], 1e3 * state["deflection_m"], color=TRUTH, label="deflection of the tip")
    axes.plot(
        frames["received_s"], 1e3 * shown, ".", color=BLUE, label="images, when the controller reads them"
    )
    axes.annotate("74 ms", (2.83, -4.9), color=BLUE, ha="center")
    axes.set(xlim=(1.9, 3.1), ylim=(-7.5, 9.0), xlabel="time, s", ylabel="mm")
    axes.legend(loc="upper right", ncols=2)
    save(figure, path)
