"""Recordings made in virtual time, with one effect in the rig that the assumed model does not have."""

from math import isnan
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from common.causes import CAUSES, Cause
from common.model import Model, load_model
from common.scenario import Move, Scenario, Strike
from simulation.simulated_recording import default_simulation_configuration, write_simulated_recording

MODEL_FILE = default_simulation_configuration().with_name("model.toml")
MODEL: Model = load_model(MODEL_FILE)

SCENARIO = Scenario(
    duration_s=20.0,
    strikes=[Strike(0.6, 0.02), Strike(9.3, -0.015), Strike(15.4, 0.02)],
    moves=[
        Move(3.5, 4.3, 0.25),
        Move(4.6, 5.6, -0.2),
        Move(6.3, 7.3, 0.03, 0.2),
        Move(7.5, 8.7, -0.05, 0.2),
        Move(11.6, 12.2, -0.3),
        Move(12.6, 13.5, 0.25, 0.1),
        Move(13.9, 15.1, 0.02, 0.1),
        Move(17.6, 18.1, -0.2),
        Move(18.2, 18.9, 0.15),
    ],
)
"""Three blows and moves both quick and slow: each cause has something to show itself by."""

_SIZES: dict[str, dict[str, Any]] = {
    "second_bending_mode": {"frequency_hz": 15.0, "damping_ratio": 0.01, "participation": -0.3},
    "coulomb_damping": {"force_per_mass_m_s2": 0.05},
    "quadratic_damping": {"coefficient_per_m": 10.0},
    "cubic_stiffness": {"coefficient_per_m2": 150.0},
    "payload_change": {"onset_s": 9.0, "frequency_ratio": 0.9},
    "stiffness_drift": {"frequency_rate_hz_per_s": -0.008},
    "periodic_disturbance": {"frequency_hz": 4.3, "amplitude_m_s2": 0.5, "phase_rad": 0.7},
    "drive_dead_time": {"dead_time_s": 0.03},
    "drive_lag": {"bandwidth_hz": 4.0},
    "drive_saturation": {"max_velocity_rad_s": 0.15},
    "drive_deadband": {"deadband_rad_s": 0.04},
    "gear_backlash": {"gap_rad": 0.01},
    "joint_friction": {"velocity_loss_rad_s": 0.015},
    "accelerometer_bias_drift": {"rate_m_s3": 0.05},
    "accelerometer_sensitivity_drift": {"rate_per_s": 0.02},
    "accelerometer_clipping": {"range_m_s2": 2.0},
    "accelerometer_lag": {"delay_s": 0.03},
    "gravity_leakage": {"gain_m_s2_per_rad": 9.8},
    "mains_hum": {"frequency_hz": 50.0, "amplitude_m_s2": 1.0, "phase_rad": 0.7},
    "impulse_noise": {"rate_hz": 3.0, "amplitude_m_s2": 10.0},
    "tracking_drift": {"rate_px_per_s": 0.1},
    "lens_distortion": {"coefficient_per_px2": 1e-6},
    "camera_tilt_coupling": {"rotation_px_per_rad": 200.0},
    "camera_clock_skew": {"skew_ppm": 500.0},
    "frame_drops": {"fraction": 0.1},
    "delay_bursts": {"rate_hz": 0.5, "duration_s": 0.4, "delay_s": 0.08},
    "delay_drift": {"rate_s_per_s": 0.008},  # the delay's usual wander is worth 0.0004 in twenty seconds
    "stale_frame_buffer": {"onset_s": 9.0, "frames": 2},
    "clock_step": {"onset_s": 9.0, "step_s": 0.1},
}


def _largest_usual(cause: Cause) -> dict[str, Any]:
    """Sizes at the upper end of what is usual, other numbers in the middle of it."""
    values = {}
    for one in cause.numbers:
        low, high = one.typical
        if one.default is None:
            values[one.name] = (low * high) ** 0.5 if isnan(one.neutral) else one.neutral + high
    return values


SIZES = {name: _SIZES.get(name) or _largest_usual(cause) for name, cause in CAUSES.items()}
"""Each cause at a size that shows clearly within twenty seconds."""


def record(
    folder: Path,
    *effects: dict[str, Any],
    seed: int = 3,
    scenario: Scenario = SCENARIO,
    assumed: Model = MODEL,
    true: Model | None = None,
) -> Path:
    """A recording of the rig that has the effects, made by a controller that assumes a model without them."""
    folder.mkdir(parents=True, exist_ok=True)
    rig = msgspec.structs.replace(true or assumed, effects=list(effects))
    for name, what in (("true", rig), ("assumed", assumed), ("scenario", scenario)):
        (folder / f"{name}.toml").write_text(tomli_w.dumps(_present(msgspec.to_builtins(what))))
    write_simulated_recording(
        true_model_path=folder / "true.toml",
        assumed_model_path=folder / "assumed.toml",
        scenario_name=str(folder / "scenario.toml"),
        seed=seed,
        recording_path=folder / "recording.mcap",
        truth_path=folder / "truth.mcap",
    )
    return folder / "recording.mcap"


def effect(cause: str, **values: Any) -> dict[str, Any]:
    """The cause at its clear size, or with other values."""
    return {"cause": cause, **SIZES[cause], **values}


def _present(value: Any) -> Any:
    """Without what is None: TOML has no such value."""
    if isinstance(value, dict):
        return {key: _present(one) for key, one in value.items() if one is not None}
    if isinstance(value, list):
        return [_present(one) for one in value]
    return value
