"""Every effect that can be hidden: its forms, between which sizes, from an onset or not, and what truth.json says of
it.

CAUSES are the contract's; UNLISTED has no name there. The unit of a size stands beside its bounds.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.hidden_world.rigs.arm_effects import coulomb_force, saturation_limit
from tests.hidden_world.rigs.inputs import scale_m
from tests.hidden_world.rigs.rig import Effect, Rig, log_uniform

Extras = Callable[[np.random.Generator, Rig], dict[str, float]]
Told = Callable[[Rig, Effect], dict[str, float]]


def _none(chance: np.random.Generator, rig: Rig) -> dict[str, float]:
    return {}


@dataclass(frozen=True)
class Entry:
    """low, high: of the size. onset: share of cases that begin inside the recording. fitted: the size is looked for
    so that the change has a drawn size in units of the noise; else it is drawn between the bounds. needs:
    "accelerometer", "stamps"."""

    forms: tuple[str, ...]
    low: float
    high: float
    told: Told
    extras: Extras = _none
    onset: float = 0.0
    fitted: bool = True
    signed: bool = True
    needs: str = ""


def _rate(rig: Rig, effect: Effect) -> float:
    """Of what reaches the size by the end, per s."""
    return effect.sign * effect.size / (rig.duration_s - effect.onset_s)


def _acceleration_noise(rig: Rig) -> float:
    assert rig.accelerometer is not None
    return rig.accelerometer.noise_m_s2


_SENSOR_DRIFTS = ("linear", "sqrt", "exponential", "random_walk")

CAUSES: dict[str, Entry] = {
    "second_bending_mode": Entry(
        ("plain", "struck_too"),
        3e-4,  # participation
        0.35,
        lambda rig, e: {
            "frequency_hz": rig.modes[0].frequency_hz * e.extras["ratio"],
            "damping_ratio": e.extras["damping_ratio"],
            "participation": e.sign * e.size,
        },
        lambda chance, rig: {
            "ratio": float(chance.uniform(3.0, 7.0)),
            "damping_ratio": log_uniform(chance, 0.002, 0.03),
        },
    ),
    "coulomb_damping": Entry(
        ("sharp", "smooth"),
        1e-4,  # of the usual bending's acceleration
        0.3,
        lambda rig, e: {"force_per_mass_m_s2": coulomb_force(rig, e)},
        onset=0.2,
        signed=False,
    ),
    "quadratic_damping": Entry(
        ("power",),
        5e-4,  # over 1 / usual bending
        0.5,
        lambda rig, e: {"coefficient_per_m": e.size / scale_m(rig), "exponent": e.extras["power"]},
        lambda chance, rig: {"power": float(chance.choice([2.0, chance.uniform(1.8, 2.2)]))},
        onset=0.2,
        signed=False,
    ),
    "cubic_stiffness": Entry(
        ("cubic", "with_fifth_order"),
        3e-4,  # of the stiffness at the usual bending
        0.3,
        lambda rig, e: {"coefficient_per_m2": e.sign * e.size / scale_m(rig) ** 2},
        lambda chance, rig: {"fifth": float(chance.uniform(-0.15, 0.15))},
        onset=0.15,
    ),
    "payload_change": Entry(
        ("abrupt", "in_0.3_s", "mass"),
        5e-4,  # of the frequency
        0.2,
        lambda rig, e: {"onset_s": e.onset_s, "frequency_ratio": 1.0 + e.sign * e.size},
        onset=1.0,
    ),
    "stiffness_drift": Entry(
        ("linear", "exponential", "sqrt"),
        2e-4,  # of the frequency, by the end
        0.1,
        lambda rig, e: {"frequency_rate_hz_per_s": rig.modes[0].frequency_hz * _rate(rig, e)},
        onset=0.2,
    ),
    "periodic_disturbance": Entry(
        ("steady", "wandering_phase", "two_tones"),
        1e-4,  # of the usual bending's acceleration
        0.4,
        lambda rig, e: {"frequency_hz": e.extras["frequency_hz"], "amplitude_m_s2": coulomb_force(rig, e)},
        lambda chance, rig: {
            "frequency_hz": rig.modes[0].frequency_hz
            * float(chance.choice([log_uniform(chance, 0.3, 0.85), log_uniform(chance, 1.2, 6.0)]))
        },
        onset=0.4,
        signed=False,
    ),
    "drive_dead_time": Entry(
        ("fixed", "jitter"),
        0.001,  # s, more than declared
        0.04,
        lambda rig, e: {"dead_time_s": rig.drive.dead_time_s + e.size, "extra_dead_time_s": e.size},
        onset=0.3,
        signed=False,
    ),
    "drive_lag": Entry(
        ("first_order", "second_pole", "speeding_up"),
        0.05,  # relative growth of the time constant
        3.0,
        lambda rig, e: {"bandwidth_hz": rig.drive.bandwidth_hz / (1.0 + e.size)},
        signed=False,
    ),
    "drive_saturation": Entry(
        ("velocity", "velocity_by_direction", "acceleration", "acceleration_by_direction"),
        0.01,  # by how much the fastest command exceeds the limit
        8.0,
        lambda rig, e: {
            (
                "max_acceleration_rad_s2" if e.form.startswith("acceleration") else "max_velocity_rad_s"
            ): saturation_limit(e)
        },
    ),
    "drive_deadband": Entry(
        ("hard", "hysteretic"),
        0.01,  # of the fastest command
        0.3,
        lambda rig, e: {"deadband_rad_s": e.size * rig.fastest_rad_s},
        onset=0.2,
        signed=False,
    ),
    "gear_backlash": Entry(
        ("impact", "standing"),
        2e-4,  # rad
        0.03,
        lambda rig, e: {"gap_rad": e.size},
        signed=False,
    ),
    "joint_friction": Entry(
        ("velocity_loss", "coulomb", "stiction", "by_direction"),
        0.003,  # of the fastest command
        0.25,
        lambda rig, e: {
            "velocity_loss_rad_s": e.size
            * rig.fastest_rad_s
            * (0.5 * (1.0 + e.extras["other_way"]) if e.form == "by_direction" else 1.0)
        },
        lambda chance, rig: {"other_way": float(chance.uniform(0.3, 0.7))},
        onset=0.2,
    ),
    "accelerometer_bias_drift": Entry(
        _SENSOR_DRIFTS,
        0.01,  # m/s^2, by the end
        30.0,
        lambda rig, e: {"rate_m_s3": _rate(rig, e), "end_m_s2": e.sign * e.size},
        onset=0.2,
        needs="accelerometer",
    ),
    "accelerometer_sensitivity_drift": Entry(
        _SENSOR_DRIFTS,
        0.002,  # of the sensitivity, by the end
        0.6,
        lambda rig, e: {"rate_per_s": _rate(rig, e), "change_at_end": e.sign * e.size},
        onset=0.2,
        needs="accelerometer",
    ),
    "accelerometer_clipping": Entry(
        ("hard", "soft", "one_side"),
        0.02,  # by how much the largest reading exceeds the limit
        9.0,
        lambda rig, e: {"range_m_s2": e.extras["peak_m_s2"] / (1.0 + e.size)},
        needs="accelerometer",
    ),
    "accelerometer_lag": Entry(
        ("delay", "first_order", "second_order"),
        2e-4,  # s
        0.03,
        lambda rig, e: {"delay_s": e.size},
        signed=False,
        needs="accelerometer",
    ),
    "gravity_leakage": Entry(
        ("angle", "sine", "sine_with_slope"),
        0.01,  # m/s^2 per rad
        9.8,
        lambda rig, e: {"gain_m_s2_per_rad": e.sign * e.size},
        needs="accelerometer",
    ),
    "mains_hum": Entry(
        ("sine", "third_harmonic", "swelling"),
        0.003,  # m/s^2
        20.0,
        lambda rig, e: {"frequency_hz": e.extras["frequency_hz"], "amplitude_m_s2": e.size},
        lambda chance, rig: {
            "frequency_hz": float(chance.choice([50.0, 50.0, 60.0])) + float(chance.normal(0.0, 0.02))
        },
        onset=0.4,
        signed=False,
        needs="accelerometer",
    ),
    "impulse_noise": Entry(
        ("equal", "exponential", "two_samples"),
        0.1,  # m/s^2
        100.0,
        lambda rig, e: {"rate_hz": e.extras["rate_hz"], "amplitude_m_s2": e.size},
        lambda chance, rig: {"rate_hz": log_uniform(chance, 0.2, 5.0)},
        onset=0.2,
        signed=False,
        needs="accelerometer",
    ),
    "tracking_drift": Entry(
        ("linear", "random_walk", "path", "steps_with_reset", "exponential", "sqrt"),
        0.02,  # px, by the end
        120.0,
        lambda rig, e: {"rate_px_per_s": _rate(rig, e), "end_px": e.sign * e.size},
        onset=0.25,
    ),
    "lens_distortion": Entry(
        ("third_order", "fifth_order", "off_centre"),
        3e-4,  # of the scale, at the edge
        0.12,
        lambda rig, e: {
            "coefficient_per_px2": e.sign * e.size / e.extras["edge_px"] ** 2,
            "centre_px": e.extras.get("centre_px", 0.0),
        },
    ),
    "camera_tilt_coupling": Entry(
        ("angle", "sine", "joint_alone"),
        0.5,  # px/rad
        400.0,
        lambda rig, e: {"rotation_px_per_rad": rig.camera.rotation_px_per_rad + e.sign * e.size},
    ),
    "camera_clock_skew": Entry(
        ("steady", "warming", "from_onset"),
        5.0,  # ppm
        2000.0,
        lambda rig, e: {"skew_ppm": e.sign * e.size},
        needs="freerun",
    ),
    "frame_drops": Entry(
        ("single", "runs"),
        0.02,  # share of the frames
        0.35,
        lambda rig, e: {"fraction": e.size},
        lambda chance, rig: {"run": float(chance.uniform(1.5, 5.0))},
        onset=0.2,
        fitted=False,
        signed=False,
    ),
    "delay_bursts": Entry(
        ("equal", "varied", "draining"),
        0.03,  # s
        0.15,
        lambda rig, e: {
            "rate_hz": e.extras["rate_hz"],
            "duration_s": e.extras["duration_s"],
            "delay_s": e.size,
        },
        lambda chance, rig: {
            "rate_hz": log_uniform(chance, 0.1, 0.6),
            "duration_s": log_uniform(chance, 0.1, 0.6),
        },
        onset=0.15,
        fitted=False,
        signed=False,
    ),
    "delay_drift": Entry(
        ("linear", "bent", "random_walk", "exponential"),
        0.002,  # s, by the end
        0.08,
        lambda rig, e: {"rate_s_per_s": _rate(rig, e)},
        onset=0.2,
    ),
    "stale_frame_buffer": Entry(
        ("content", "with_stamp", "queue"),
        1.0,  # frames
        3.0,
        lambda rig, e: {"onset_s": e.onset_s, "frames": e.size},
        onset=1.0,
        fitted=False,
        signed=False,
    ),
    "clock_step": Entry(
        ("frames", "camera"),
        0.015,  # s
        0.25,
        lambda rig, e: {"onset_s": e.onset_s, "step_s": e.sign * e.size},
        onset=1.0,
        fitted=False,
    ),
}


def _side(low: float, high: float) -> Extras:
    return lambda chance, rig: {
        "ratio": float(chance.uniform(low, high)),
        "damping_ratio": log_uniform(chance, 0.003, 0.03),
        "leak": float(chance.uniform(0.3, 1.0)),
    }


def _untold(rig: Rig, effect: Effect) -> dict[str, float]:
    return dict(effect.extras)


UNLISTED: dict[str, Entry] = {
    "asymmetric_stiffness": Entry(("two_slopes",), 3e-4, 0.4, _untold),
    "bouc_wen_hysteresis": Entry(
        ("bouc_wen",),
        1e-3,
        0.4,
        _untold,
        lambda chance, rig: {
            "width": log_uniform(chance, 0.05, 0.5),
            "power": float(chance.choice([1.0, 2.0])),
        },
        signed=False,
    ),
    "cross_axis_coupling": Entry(
        ("both_ways",), 1e-3, 0.25, _untold, _side(0.6, 1.6), signed=False, needs="accelerometer"
    ),
    "accelerometer_gain_nonlinear": Entry(("odd", "even"), 1e-3, 0.2, _untold, needs="accelerometer"),
    "centrifugal_softening": Entry(("square",), 3e-3, 0.5, _untold, signed=False),
    "image_scale_drift": Entry(("linear", "exponential", "random_walk"), 3e-4, 0.15, _untold, onset=0.3),
    "torsion_in_image": Entry(
        ("twist",), 1e-3, 1.0, _untold, _side(1.5, 5.0), signed=False, needs="accelerometer"
    ),
    "stop_contact": Entry(
        ("one_side",),
        3e-3,
        5.0,
        _untold,
        lambda chance, rig: {"at": float(chance.uniform(0.2, 0.8))},
        signed=False,
    ),
    "loose_camera_mount": Entry(
        ("ringing",),
        1e-3,
        2.0,
        _untold,
        lambda chance, rig: {
            "frequency_hz": float(chance.uniform(0.18, 0.42)) * rig.camera.frame_rate_hz,
            "damping_ratio": log_uniform(chance, 0.005, 0.05),
        },
        needs="accelerometer",
        signed=False,
    ),
    "drive_gain_by_direction": Entry(("gain",), 1e-3, 0.2, _untold),
    "random_tip_force": Entry(
        ("gusts",),
        1e-4,
        0.4,
        _untold,
        lambda chance, rig: {"time_s": log_uniform(chance, 0.1, 2.0) / rig.modes[0].frequency_hz},
        onset=0.2,
        signed=False,
    ),
}

ALL = CAUSES | UNLISTED


_SAME_WITHOUT_ENCODER = {
    "joint_friction": ["drive_deadband"],
    "drive_deadband": ["joint_friction"],
    "accelerometer_lag": ["drive_dead_time"],
    "drive_dead_time": ["accelerometer_lag"],
    "drive_lag": ["accelerometer_lag", "drive_dead_time"],
    "gear_backlash": ["coulomb_damping", "cubic_stiffness"],
}
_SAME_WITHOUT_CLOCK = {"camera_clock_skew": ["delay_drift"], "delay_drift": ["camera_clock_skew"]}


def also(rig: Rig, effect: Effect) -> list[str]:
    """Causes that are the same law in this recording: the contract's pairs that cannot be told apart."""
    cause, encoder, stamped = effect.cause, rig.encoder, rig.camera.stamped
    same: list[str] = []
    if encoder is None or (cause == "gear_backlash" and encoder.at_motor):
        same = _SAME_WITHOUT_ENCODER.get(cause, [])
    if not (rig.accelerometer or encoder or stamped):
        same = same + _SAME_WITHOUT_CLOCK.get(cause, [])
    if cause == "stale_frame_buffer" and (effect.form == "queue" or not stamped):
        same = ["clock_step"]
    if cause == "clock_step" and effect.form == "frames" and not stamped and effect.sign > 0:
        frames = effect.size * rig.camera.frame_rate_hz
        near = abs(frames - round(frames)) / rig.camera.frame_rate_hz < rig.arrival.std_s
        same = ["stale_frame_buffer"] if near and 1 <= round(frames) <= 3 else []
    return same
