"""A case as files: fast.csv, frames.csv and model.toml, as anybody's measured data comes in; truth.json for the
judge."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from tests.hidden_world.rigs.case import Case
from tests.hidden_world.rigs.catalogue import ALL
from tests.hidden_world.rigs.rig import TICK_S, Values, luck

_FAST = {"time_s": "%.4f", "joint_position_rad": "%.7f"}


def write_bundle(case: Case, folder: Path) -> None:
    """Write the four files; `folder` is made."""
    write_data(case, folder)
    (folder / "truth.json").write_text(json.dumps(truth(case), indent=1))


def write_data(case: Case, folder: Path) -> None:
    """Write what is measured and the model file, without what is hidden; `folder` is made."""
    folder.mkdir(parents=True, exist_ok=True)
    recording, seen = case.recording, case.recording.images
    fast = {"time_s": np.arange(case.rig.cycles) * TICK_S}
    if recording.acceleration is not None:
        fast["acceleration_m_s2"] = recording.acceleration
    fast["joint_velocity_command_rad_s"] = recording.motion.asked
    if recording.position is not None and recording.speed is not None:
        fast |= {"joint_position_rad": recording.position, "joint_velocity_rad_s": recording.speed}
    _write(folder / "fast.csv", fast, {name: _FAST.get(name, "%.6g") for name in fast})
    frames = {
        "frame": seen.number.astype(float),
        "received_s": seen.received_s,
        "started_s": seen.started_s,
        "displacement_px": recording.px,
    }
    formats = {"frame": "%d", "received_s": "%.4f", "started_s": "%.4f", "displacement_px": "%.4f"}
    if case.rig.camera.stamped:
        frames["captured_s"], formats["captured_s"] = seen.stamp_s, "%.6f"
    _write(folder / "frames.csv", frames, formats)
    (folder / "model.toml").write_text(model_text(case))


def truth(case: Case) -> dict[str, object]:
    """truth.json. `seen` is what the effects change in each channel beyond what a baseline's refit takes up
    (refit.py)."""
    rig = case.rig
    told = asdict(rig)
    told["encoder"], told["accelerometer"] = told["encoder"] or "absent", told["accelerometer"] or "absent"
    named = {e.cause: ALL[e.cause].told(rig, e) for e in case.effects}
    return {
        "expected": case.expected,
        "cause": case.cause,
        "also": case.also(),
        "effects": [
            {
                "cause": e.cause,
                "size": e.size,
                "sign": e.sign,
                "onset_s": e.onset_s,
                "form": e.form,
                "size_in_noise": size,
                "parameters": named[e.cause],
            }
            for e, size in zip(case.effects, case.sizes, strict=True)
        ],
        "parameters": named.get(case.cause or "", {}),
        "doubtful": case.doubtful,
        "size_in_noise": max(case.sizes, default=0.0),
        "seen": {name: asdict(d) for name, d in case.seen.items()},
        "seen_without_refit": {name: asdict(d) for name, d in case.raw.items()},
        "nuisance_in_noise": case.nuisance,
        "moves": [m.told() for m in case.moves],
        "model_off_percent": model_off_percent(case),
        "rig": told,
    }


def model_off_percent(case: Case) -> float:
    chance = luck(case.rig.seed, 61)
    return float(chance.choice([0.0, chance.uniform(0.2, 4.0)], p=[0.3, 0.7]))


def model_text(case: Case) -> str:
    """model.toml: right but for what a baseline refits."""
    rig, chance, off = case.rig, luck(case.rig.seed, 62), model_off_percent(case)
    camera = rig.camera

    def near(value: float, share: float) -> str:
        return (
            f"{value * (1.0 + 0.01 * share * off * float(np.clip(chance.normal(0.0, 0.5), -1.0, 1.0))):.6g}"
        )

    lines = ["[arm]", f"length_m = {rig.length_m:.6g}"]
    for mode in rig.modes:
        lines += [
            "[[arm.modes]]",
            f"frequency_hz = {near(mode.frequency_hz, 0.5)}",
            f"damping_ratio = {near(mode.damping_ratio, 4.0)}",
            f"participation = {near(mode.participation, 1.0)}",
        ]
    lines += [
        "[drive]",
        f"bandwidth_hz = {rig.drive.bandwidth_hz:.6g}",
        f"dead_time_s = {rig.drive.dead_time_s:.6g}",
        f"max_velocity_rad_s = {rig.drive.max_velocity_rad_s:.6g}",
        f"max_acceleration_rad_s2 = {rig.drive.max_acceleration_rad_s2:.6g}",
        "min_position_rad = -3.0",
        "max_position_rad = 3.0",
    ]
    if sensor := rig.accelerometer:
        bias = float(chance.choice([0.0, sensor.bias_m_s2]))
        lines += [
            "[accelerometer]",
            f"scale = {sensor.scale:g}",
            f"noise_std_m_s2 = {near(sensor.noise_m_s2, 3.0)}",
            f"bias_m_s2 = {bias:.6g}",
            f"range_m_s2 = {sensor.range_m_s2:g}",
        ]
    lines += [
        "[camera]",
        f'mode = "{"triggered" if camera.triggered else "freerun"}"',
        f"frame_rate_hz = {camera.frame_rate_hz:g}",
        f"exposure_s = {camera.exposure_s:.6g}",
        f"scale_px_per_m = {near(camera.scale_px_per_m, 1.0)}",
        f"rotation_px_per_rad = {camera.rotation_px_per_rad:.6g}",
        f"noise_std_px = {near(camera.noise_px, 3.0)}",
        "[timing]",
        f"cycle_s = {TICK_S:g}",
        f"capture_delay_s = {near(rig.arrival.mean_s, 1.0)}",
        f"capture_delay_std_s = {near(rig.arrival.std_s, 3.0)}",
    ]
    return "\n".join(lines) + "\n"


def _write(path: Path, columns: dict[str, Values], formats: dict[str, str]) -> None:
    line = ",".join(formats[name] for name in columns)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    path.write_text("\n".join([",".join(columns), *(line % row for row in rows)]) + "\n")
