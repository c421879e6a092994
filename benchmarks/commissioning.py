"""Benchmark of commissioning: rigs of random parameters in virtual time, of which the assumed model knows none.

Each rig is drawn from its seed: frequency 1 to 8 Hz, damping ratio 0.2 to 3 %, participation, either sign of each
sensor, scales x 0.3 to x 3, bias, noise levels, capture delay 20 to 150 ms and its spread, the drive's bandwidth and
dead time, the camera's frame rate. No frame can arrive before its exposure, which bounds the spread of a short delay.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import tomli_w

from stillarm.common.files.model import Mode, Model, load_model
from stillarm.common.files.scenario import Scenario, Strike, Window
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.commissioning.plan import Limits
from stillarm.diagnosis.commissioning.procedure import Commissioning, commission
from stillarm.diagnosis.commissioning.watch import Bounds
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.reading import read_measured
from stillarm.diagnosis.report.extended_model import model_text
from stillarm.simulation.demo.ring_down import envelope_m, settling_time_s
from stillarm.simulation.virtual_time.simulated_recording import (
    default_simulation_configuration,
    write_simulated_recording,
)

_STREAM = 9117
_NEED = {  # allowed relative errors: the requirements on commissioning
    "arm.modes[0].frequency_hz": 0.005,
    "arm.modes[0].damping_ratio": 0.15,
    "accelerometer.scale": 0.02,
    "camera.scale_px_per_m": 0.02,
}
_STRUCK_M, _STRUCK_S, _DAMPED_S = 0.00625, 1.0, 12.0


@dataclass(frozen=True)
class Judged:
    """One rig: errors over stated deviations, relative errors, and the damping with the identified model."""

    seed: int
    true: Model
    done: Commissioning
    errors: dict[str, tuple[float, float]]
    settling_true_s: float | None
    settling_found_s: float | None
    residual_true: float
    residual_found: float

    @property
    def signs_right(self) -> bool:
        """Whether the signs of both sensors and of the participation are right."""
        found, true = self.done.found.model, self.true
        return bool(
            np.sign(found.accelerometer.scale) == np.sign(true.accelerometer.scale)
            and np.sign(found.camera.scale_px_per_m) == np.sign(true.camera.scale_px_per_m)
            and np.sign(found.arm.modes[0].participation) == np.sign(true.arm.modes[0].participation)
        )

    @property
    def within_need(self) -> bool:
        """Whether frequency, damping ratio and scales are within the allowed errors."""
        return all(abs(self.errors[key][1]) <= most for key, most in _NEED.items())

    @property
    def damps(self) -> bool:
        """Whether the arm settles as with the true model or, if neither settles, leaves as little vibration."""
        true, found = self.settling_true_s, self.settling_found_s
        if true is not None and found is not None:
            return found <= 1.25 * true + 0.2
        return self.residual_found <= 1.25 * self.residual_true + 0.02


def assumed_model() -> Model:
    """The starting model for all rigs, which comes with the program."""
    return load_model(default_simulation_configuration().with_name("model.toml"))


def draw_rig(seed: int) -> Model:
    """A rig's true model."""
    random = np.random.default_rng((_STREAM, seed))

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    base, replace = assumed_model(), msgspec.structs.replace
    accelerometer_sign, seen = (float(sign) for sign in random.choice([-1.0, 1.0], 2))
    mode = Mode(between(1.0, 8.0), between(0.002, 0.03), float(random.uniform(0.9, 1.4)))
    delay = float(random.uniform(0.02, 0.15))
    return replace(
        base,
        arm=replace(base.arm, modes=[mode]),
        drive=replace(
            base.drive, bandwidth_hz=between(8.0, 40.0), dead_time_s=float(random.uniform(0.0, 0.012))
        ),
        accelerometer=replace(
            base.accelerometer,
            scale=accelerometer_sign * between(0.3, 3.0),
            bias_m_s2=float(random.normal(0.0, 0.3)),
            noise_std_m_s2=between(0.1, 0.8),
        ),
        camera=replace(
            base.camera,
            scale_px_per_m=seen * 800.0 * between(0.3, 3.0),
            noise_std_px=between(0.03, 0.1),
            frame_rate_hz=65.0 * (1.0 + 1e-4 * float(random.normal())),
        ),
        timing=replace(
            base.timing,
            capture_delay_s=delay,
            capture_delay_std_s=min(between(0.002, 0.008), max(0.0, 0.25 * (delay - _EARLIEST_S))),
        ),
    )


_EARLIEST_S = 0.0165  # half the exposure, transfer, tracking


UNDAMPED = "timestamps"
"""The quickest method: where damping is off, what is measured is the same by any."""


def simulated(
    true: Model, assumed: Model, scenario: Scenario, seed: int, folder: Path, method: str | None = None
) -> tuple[Path, Path]:
    """Run a scenario in virtual time. Returns the paths of the recording and of its truth file. method: the
    controller's, None for the usual one."""
    folder.mkdir(parents=True, exist_ok=True)
    names = {"true": model_text(true), "assumed": model_text(assumed)}
    names["scenario"] = tomli_w.dumps(msgspec.to_builtins(scenario))
    for name, text in names.items():
        (folder / f"{name}.toml").write_text(text)
    recording, truth = folder / "recording.mcap", folder / "truth.mcap"
    write_simulated_recording(
        true_model_path=folder / "true.toml",
        assumed_model_path=folder / "assumed.toml",
        scenario_name=str(folder / "scenario.toml"),
        seed=seed,
        recording_path=recording,
        truth_path=truth,
        method=method,
    )
    return recording, truth


def commission_virtually(true: Model, assumed: Model, seed: int, folder: Path) -> Commissioning:
    """Run the procedure on a rig in virtual time. Each part has independent noise, from the seed."""

    def record(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        part = {"probe": 0, "moves": 1}[name]
        path, _ = simulated(true, assumed, scenario, 10 * seed + part, folder / name, UNDAMPED)
        return read_measured(open_recording(path), assumed)

    return commission(record, assumed, Limits())


def damped(true: Model, assumed: Model, seed: int, folder: Path) -> tuple[float | None, float]:
    """Strike with damping on. Returns the settling time, s (None: not reached), and the rms envelope of the last third
    over the struck amplitude.
    """
    w = true.arm.modes[0].angular_frequency
    accelerometer_sign = abs(true.accelerometer.scale) * w * w
    struck = min(_STRUCK_M, 0.4 * true.accelerometer.range_m_s2 / accelerometer_sign)
    scenario = Scenario(
        duration_s=_STRUCK_S + _DAMPED_S,
        strikes=[Strike(_STRUCK_S, struck)],
        damping=[Window(0.5, _STRUCK_S + _DAMPED_S)],
    )
    _, truth = simulated(true, assumed, scenario, 10 * seed + 7, folder)
    state = open_recording(truth).columns("/truth/state")
    deflection = np.asarray(state["deflection_m"], dtype=np.float64)
    step = true.timing.cycle_s
    after = envelope_m(deflection, step, true.arm.modes[0].frequency_hz)[round(_STRUCK_S / step) :]
    rest = float(np.sqrt(np.mean(after[-round(_DAMPED_S / 3.0 / step) :] ** 2))) / struck
    return settling_time_s(after, step, struck), rest


def truth_of(true: Model) -> dict[str, float]:
    """The true value of each parameter that a calibration may state."""
    mode = true.arm.modes[0]
    return {
        "arm.modes[0].frequency_hz": mode.frequency_hz,
        "arm.modes[0].damping_ratio": mode.damping_ratio,
        "arm.modes[0].participation": mode.participation,
        "accelerometer.scale": true.accelerometer.scale,
        "accelerometer.bias_m_s2": true.accelerometer.bias_m_s2,
        "accelerometer.noise_std_m_s2": true.accelerometer.noise_std_m_s2,
        "camera.scale_px_per_m": true.camera.scale_px_per_m,
        "camera.noise_std_px": true.camera.noise_std_px,
        "camera.frame_rate_hz": true.camera.frame_rate_hz,
        "timing.capture_delay_s": true.timing.capture_delay_s,
        "timing.capture_delay_std_s": true.timing.capture_delay_std_s,
        "drive.bandwidth_hz": true.drive.bandwidth_hz,
        "drive.dead_time_s": true.drive.dead_time_s,
    }


def judge_rig(seed: int, folder: Path) -> Judged:
    """Commission one rig and compare."""
    true, assumed = draw_rig(seed), assumed_model()
    done = commission_virtually(true, assumed, seed, folder)
    errors = {}
    for key, value in truth_of(true).items():
        found, std = done.found.parameters.get(key, (nan, nan))
        errors[key] = ((found - value) / std, (found - value) / (value or 1.0))
    settling_true, rest_true = damped(true, true, seed, folder / "damped-true")
    settling_found, rest_found = damped(true, done.found.model, seed, folder / "damped-found")
    return Judged(seed, true, done, errors, settling_true, settling_found, rest_true, rest_found)


def run(rigs: int, seed: int, progress: Callable[[float], None] = lambda done: None) -> dict[str, Any]:
    """Commission the rigs of seeds seed, seed + 1, ... A refused rig counts against every figure."""
    judged: list[Judged] = []
    refused: list[dict[str, Any]] = []
    for i in range(rigs):
        with tempfile.TemporaryDirectory() as folder:
            try:
                judged.append(judge_rig(seed + i, Path(folder)))
            except UserError as error:
                refused.append({"seed": seed + i, "error": str(error)})
        progress((i + 1) / rigs)
    return summary(judged, refused)


def summary(judged: list[Judged], refused: list[dict[str, Any]]) -> dict[str, Any]:
    """The tables: by parameter, by rig, and the overall fractions."""
    total = len(judged) + len(refused)
    keys = list(truth_of(assumed_model()))
    parameters = []
    for key in keys:
        sizes = np.array([one.errors[key] for one in judged]).reshape(-1, 2)
        normalised = sizes[:, 0]
        parameters.append(
            {
                "parameter": key,
                "within_3_std": float(np.mean(np.abs(normalised) <= 3.0)) if len(sizes) else 0.0,
                "rms_over_std": float(np.sqrt(np.mean(normalised**2))) if len(sizes) else None,
                "largest_over_std": float(np.max(np.abs(normalised))) if len(sizes) else None,
                "largest_error_percent": float(100.0 * np.max(np.abs(sizes[:, 1]))) if len(sizes) else None,
            }
        )
    inside = [abs(one.errors[key][0]) <= 3.0 for one in judged for key in keys]
    return {
        "rigs": total,
        "refused": refused,
        "parameters": parameters,
        "rows": [_row(one) for one in judged],
        "within_3_std": sum(inside) / max(len(keys) * total, 1),
        "within_need": sum(one.within_need for one in judged) / max(total, 1),
        "signs_right": sum(one.signs_right for one in judged) / max(total, 1),
        "verdicts_good": sum(one.done.verdict.good for one in judged) / max(total, 1),
        "damps_at_once": sum(one.damps for one in judged) / max(total, 1),
    }


def _row(one: Judged) -> dict[str, Any]:
    mode, errors = one.true.arm.modes[0], one.errors
    worst = max(errors, key=lambda key: abs(errors[key][0]) if isfinite(errors[key][0]) else float("inf"))
    return {
        "seed": one.seed,
        "frequency_hz": mode.frequency_hz,
        "damping_ratio": mode.damping_ratio,
        "delay_s": one.true.timing.capture_delay_s,
        "frequency_error_percent": 100.0 * errors["arm.modes[0].frequency_hz"][1],
        "damping_error_percent": 100.0 * errors["arm.modes[0].damping_ratio"][1],
        "felt_error_percent": 100.0 * errors["accelerometer.scale"][1],
        "seen_error_percent": 100.0 * errors["camera.scale_px_per_m"][1],
        "delay_error_s": errors["timing.capture_delay_s"][1] * one.true.timing.capture_delay_s,
        "worst": worst,
        "worst_over_std": errors[worst][0],
        "settling_true_s": one.settling_true_s,
        "settling_found_s": one.settling_found_s,
        "rest_true": one.residual_true,
        "rest_found": one.residual_found,
        "recorded_s": one.done.plan.duration_s,
        "verdict": one.done.verdict.good,
    }


_SHOWN = {
    "seed": "seed",
    "frequency_hz": "f_hz",
    "damping_ratio": "zeta",
    "delay_s": "delay_s",
    "frequency_error_percent": "f_err_%",
    "damping_error_percent": "zeta_err_%",
    "felt_error_percent": "felt_err_%",
    "seen_error_percent": "seen_err_%",
    "delay_error_s": "delay_err_s",
    "worst": "worst",
    "worst_over_std": "/ std",
    "settling_true_s": "settles_true_s",
    "settling_found_s": "settles_s",
    "verdict": "good",
}


def shown(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The columns that fit a terminal, under short names."""
    return [{short: row[name] for name, short in _SHOWN.items()} for row in rows]
