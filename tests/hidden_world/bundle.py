"""A recording as the CSV bundle that measured data come in. The only file that knows the program's names.

fast.csv, frames.csv and model.toml, always with the same columns; what is not measured is an empty field.
"""

from math import isfinite
from pathlib import Path

import numpy as np

from tests.hidden_world.rig import TICK_S, Rig
from tests.hidden_world.world import Recording

FAST = {
    "time_s": ("time", 9),
    "acceleration_m_s2": ("acceleration", 6),
    "joint_velocity_command_rad_s": ("command", 9),
    "joint_velocity_reference_rad_s": ("reference", 9),
    "joint_position_rad": ("angle", 8),
    "joint_velocity_rad_s": ("speed", 7),
    "deflection_m": ("gauge", 8),
}
FRAMES = {
    "frame": ("number", 0),
    "received_s": ("received", 6),
    "started_s": ("started", 6),
    "displacement_px": ("image", 5),
    "captured_s": ("stamp", 7),
}
_ALWAYS = {"time", "number", "received", "started"}


def write_bundle(recording: Recording, folder: Path) -> None:
    """Write the three files. What `case.kept` does not name is left empty; without `image`, no frames.csv."""
    folder.mkdir(parents=True, exist_ok=True)
    _write(recording, FAST, folder / "fast.csv")
    if "image" in recording.case.kept:
        _write(recording, FRAMES, folder / "frames.csv")
    (folder / "model.toml").write_text(model_text(recording.case.assumed))


def _write(recording: Recording, columns: dict[str, tuple[str, int]], path: Path) -> None:
    texts = []
    for source, digits in columns.values():
        values = np.asarray(getattr(recording, source), dtype=float)
        if source not in _ALWAYS and source not in recording.case.kept:
            values = np.full(len(values), np.nan)
        scaled = np.round(values, digits) + 0.0
        texts.append([f"{value:.{digits}f}" if isfinite(value) else "" for value in scaled.tolist()])
    lines = [",".join(columns), *map(",".join, zip(*texts, strict=True))]
    path.write_text("\n".join(lines) + "\n")


def model_text(assumed: Rig) -> str:
    """model.toml of what the owner believes."""
    joint, feeler, eye = assumed.joint, assumed.feeler, assumed.eye
    modes = "".join(
        f"[[arm.modes]]\nfrequency_hz = {b.hertz!r}\ndamping_ratio = {b.loss!r}\nparticipation = {b.share!r}\n"
        for b in assumed.bends
    )
    return f"""[arm]
length_m = {assumed.reach!r}
{modes}
[drive]
bandwidth_hz = {joint.follow_hertz!r}
dead_time_s = {joint.hold_up_s!r}
max_velocity_rad_s = {joint.top_speed!r}
max_acceleration_rad_s2 = {joint.top_acceleration!r}

[accelerometer]
scale = {feeler.gain!r}
delay_s = {feeler.lateness_s!r}
noise_std_m_s2 = {feeler.hiss!r}
bias_m_s2 = {feeler.bias!r}
range_m_s2 = {feeler.limit!r}

[camera]
mode = "{"freerun" if eye.free else "triggered"}"
frame_rate_hz = {eye.rate!r}
exposure_s = {eye.open_s!r}
scale_px_per_m = {eye.px_per_m!r}
noise_std_px = {eye.px_noise!r}

[timing]
cycle_s = {TICK_S!r}
capture_delay_s = {eye.late_s!r}
capture_delay_std_s = {eye.late_spread_s!r}
"""
