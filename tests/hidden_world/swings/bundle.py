"""A recording as a bundle with its truth: what `stillarm import` takes, and what a score compares with.

fast.csv, frames.csv, model.toml; truth_deflection.csv, truth_frames.csv, events.json; rig.json: what was drawn.
"""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.swings.informed import informed_error
from tests.hidden_world.swings.rig import TICK_S, Case
from tests.hidden_world.swings.sensors import Recording

_FORMATS = {"time_s": "%.4f", "joint_position_rad": "%.7f"}
_TRUTH_STRIDE = 20  # grid points: 2 ms


def write_bundle(recording: Recording, folder: Path) -> None:
    """Write the files; `folder` is made."""
    folder.mkdir(parents=True, exist_ok=True)
    case, seen, motion = recording.case, recording.images, recording.motion
    _write(folder / "fast.csv", recording.fast, {name: _FORMATS.get(name, "%.6g") for name in recording.fast})
    frames = {
        "frame": seen.number.astype(float),
        "received_s": seen.received_s,
        "started_s": seen.started_s,
        "displacement_px": recording.image_px,
    }
    formats = {"frame": "%d", "received_s": "%.4f", "started_s": "%.4f", "displacement_px": "%.4f"}
    if case.camera.stamped:
        frames["captured_s"], formats["captured_s"] = seen.stamp_s, "%.6f"
    _write(folder / "frames.csv", frames, formats)
    (folder / "model.toml").write_text(model_text(recording))
    stride = slice(None, None, _TRUTH_STRIDE)
    deflection = {"time_s": motion.time_s[stride], "deflection_m": motion.deflection_m[stride]}
    _write(folder / "truth_deflection.csv", deflection, {"time_s": "%.4f", "deflection_m": "%.10g"})
    truth = {"frame": seen.number.astype(float), "mid_exposure_s": seen.middle_s}
    _write(folder / "truth_frames.csv", truth, {"frame": "%d", "mid_exposure_s": "%.9f"})
    (folder / "events.json").write_text(json.dumps({"swings_s": recording.swings_s}))
    told = {"words": words(case), "informed_error": informed_error(recording)}
    (folder / "rig.json").write_text(json.dumps(asdict(case) | told, indent=1))


def words(case: Case) -> str:
    """What the rig was, in one line."""
    mode, feeler, camera, law = case.modes[0], case.accelerometer, case.camera, case.arrivals
    w = 2.0 * np.pi * mode.frequency_hz
    loud = f"{feeler.noise_m_s2 / (w * w * case.amplitude_m):.2f}" if feeler.state == "good" else feeler.state
    parts = [
        f"{mode.frequency_hz:.1f}Hz z{mode.damping_ratio:.3f} L{case.length_m:.1f}",
        f"amp/noise {case.amplitude_m / case.noise_m:.0f}",
        f"acc {loud}",
        f"{'trig' if camera.triggered else 'free'}{camera.frame_rate_hz:.0f}{'+stamp' if camera.stamped else ''}",
        f"late {1e3 * (law.floor_s + law.rest_mean_s):.0f}({1e3 * case.belief.delay_error_s:+.0f})",
        f"enc {case.joint.encoder}",
    ]
    extras = {
        f"start stall {law.start_stall_s:.2f}": law.start_stall_s > 0.0,
        "stalls": law.stall_rate_hz > 0.0,
        "tail": law.tail_share > 0.0,
        f"lost {law.lost_share:.0%}": law.lost_share > 0.0,
        f"walk {1e3 * law.walk_s:.0f}": law.walk_s > 0.002,
        "mode 2": len(case.modes) > 1,
        "age": feeler.age_s > 0.0,
        "colour": max(feeler.colour, camera.colour) > 0.0,
    }
    return ", ".join(parts + [text for text, there in extras.items() if there])


def model_text(recording: Recording) -> str:
    """model.toml of what the owner believes; one mode, whatever the arm has."""
    case, seen = recording.case, recording.images
    mode, belief = case.modes[0], case.belief
    calm = seen.middle_s > 5.0
    delay = (seen.received_s - seen.middle_s)[calm]
    low, high = np.percentile(delay, [1.0, 99.0])
    usual = delay[(delay >= low) & (delay <= high)]
    feeler = case.accelerometer
    return f"""[arm]
length_m = {case.length_m:.6g}
[[arm.modes]]
frequency_hz = {mode.frequency_hz * belief.frequency:.6g}
damping_ratio = {mode.damping_ratio * belief.damping:.6g}
participation = {mode.participation * belief.participation:.6g}
[drive]
bandwidth_hz = {case.joint.bandwidth_hz * belief.bandwidth:.6g}
dead_time_s = {case.joint.dead_time_s:.6g}
max_velocity_rad_s = {_top_speed(case):.6g}
[accelerometer]
noise_std_m_s2 = {feeler.noise_m_s2 * belief.accelerometer_noise:.6g}
bias_m_s2 = {belief.bias_m_s2:.6g}
range_m_s2 = {feeler.range_m_s2:.6g}
[camera]
mode = "{"triggered" if case.camera.triggered else "freerun"}"
frame_rate_hz = {case.camera.frame_rate_hz:.6g}
exposure_s = {case.camera.exposure_s:.6g}
scale_px_per_m = {case.camera.scale_px_per_m * belief.scale:.6g}
noise_std_px = {case.camera.noise_px * belief.image_noise:.6g}
[timing]
cycle_s = {TICK_S:g}
capture_delay_s = {max(0.02, float(np.mean(usual)) + belief.delay_error_s):.6g}
capture_delay_std_s = {max(0.001, float(np.std(usual)) * belief.delay_spread):.6g}
"""


def _top_speed(case: Case) -> float:
    moves = [2.0 * abs(event.size) / event.ramp_s for event in case.events if event.kind == "move"]
    return 1.2 * max(moves, default=0.5)


def _write(path: Path, columns: dict[str, NDArray[np.float64]], formats: dict[str, str]) -> None:
    line = ",".join(formats[name] for name in columns)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    path.write_text("\n".join([",".join(columns), *(line % row for row in rows)]) + "\n")
