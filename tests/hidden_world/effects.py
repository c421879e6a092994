"""What may be hidden. A cause carries the contract's parameter names; the rest of the world has its own.

Each has a rough form (detail 1), which is what recordings are made with, and a plain one (detail 0: a constant, a
ramp, a corner), which serves only to say which plain parameters fit the rough one best.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Effect:
    """One hidden thing: values by the contract's names (SI), `luck` the seed of its random part, `kind` its variant."""

    name: str
    values: dict[str, float] = field(default_factory=dict)
    detail: float = 1.0
    luck: int = 0
    kind: str = ""

    def __getitem__(self, key: str) -> float:
        return self.values[key]

    def with_value(self, key: str, value: float) -> "Effect":
        """The same with one value changed."""
        return replace(self, values={**self.values, key: value})

    @property
    def plain(self) -> "Effect":
        """Without the details that the rough form has."""
        return replace(self, detail=0.0)

    def chance(self, stream: int = 0) -> np.random.Generator:
        """Its own random numbers, the same at every size."""
        return np.random.default_rng((self.luck, stream))


@dataclass(frozen=True)
class Cause:
    """How one contract's cause is drawn: `size` names the parameter that is scaled, from `neutral` outwards."""

    where: str
    size: str
    smallest: float
    """Smallest and largest departure of the size from `neutral` that is worth the name on a rig."""
    largest: float
    names: tuple[str, ...]
    signed: bool = False
    relative: bool = False
    """True: the departure is a part of the rig's own value (1 + departure) x value; False: it is added."""
    law: bool = False
    """True: it changes no mean, only a law of noise or timing."""


CAUSES: dict[str, Cause] = {
    "second_bending_mode": Cause(
        "arm", "participation", 0.01, 0.4, ("frequency_hz", "damping_ratio", "participation"), signed=True
    ),
    "coulomb_damping": Cause("arm", "force_per_mass_m_s2", 0.005, 1.0, ("force_per_mass_m_s2",)),
    "quadratic_damping": Cause("arm", "coefficient_per_m", 0.05, 20.0, ("coefficient_per_m",)),
    "cubic_stiffness": Cause("arm", "coefficient_per_m2", 2.0, 3000.0, ("coefficient_per_m2",), signed=True),
    "payload_change": Cause(
        "arm", "frequency_ratio", 0.002, 0.25, ("onset_s", "frequency_ratio"), signed=True
    ),
    "stiffness_drift": Cause(
        "arm", "frequency_rate_hz_per_s", 2e-4, 0.02, ("frequency_rate_hz_per_s",), signed=True
    ),
    "periodic_disturbance": Cause("arm", "amplitude_m_s2", 0.002, 2.0, ("frequency_hz", "amplitude_m_s2")),
    "drive_dead_time": Cause("drive", "dead_time_s", 0.0005, 0.03, ("dead_time_s",)),
    "drive_lag": Cause("drive", "bandwidth_hz", 0.03, 0.7, ("bandwidth_hz",), signed=True, relative=True),
    "drive_saturation": Cause(
        "drive", "max_velocity_rad_s", 0.02, 0.9, ("max_velocity_rad_s",), relative=True
    ),
    "drive_deadband": Cause("drive", "deadband_rad_s", 0.002, 0.03, ("deadband_rad_s",)),
    "gear_backlash": Cause("drive", "gap_rad", 0.0002, 0.006, ("gap_rad",)),
    "joint_friction": Cause("drive", "velocity_loss_rad_s", 0.002, 0.03, ("velocity_loss_rad_s",)),
    "accelerometer_bias_drift": Cause("accelerometer", "rate_m_s3", 5e-4, 0.1, ("rate_m_s3",), signed=True),
    "accelerometer_sensitivity_drift": Cause(
        "accelerometer", "rate_per_s", 2e-4, 0.015, ("rate_per_s",), signed=True
    ),
    "accelerometer_clipping": Cause(
        "accelerometer", "range_m_s2", 0.001, 0.99, ("range_m_s2",), relative=True
    ),
    "accelerometer_lag": Cause("accelerometer", "delay_s", 0.0005, 0.02, ("delay_s",)),
    "gravity_leakage": Cause(
        "accelerometer", "gain_m_s2_per_rad", 0.02, 5.0, ("gain_m_s2_per_rad",), signed=True
    ),
    "mains_hum": Cause("accelerometer", "amplitude_m_s2", 0.005, 3.0, ("frequency_hz", "amplitude_m_s2")),
    "impulse_noise": Cause("accelerometer", "rate_hz", 0.05, 20.0, ("rate_hz", "amplitude_m_s2"), law=True),
    "tracking_drift": Cause("camera", "rate_px_per_s", 0.003, 2.0, ("rate_px_per_s",), signed=True),
    "lens_distortion": Cause(
        "camera", "coefficient_per_px2", 2e-9, 1e-5, ("coefficient_per_px2",), signed=True
    ),
    "camera_tilt_coupling": Cause(
        "camera", "rotation_px_per_rad", 1.0, 1500.0, ("rotation_px_per_rad",), signed=True
    ),
    "camera_clock_skew": Cause("timing", "skew_ppm", 20.0, 3000.0, ("skew_ppm",), signed=True),
    "frame_drops": Cause("timing", "fraction", 0.01, 0.4, ("fraction",), law=True),
    "delay_bursts": Cause("timing", "delay_s", 0.005, 0.08, ("rate_hz", "duration_s", "delay_s"), law=True),
    "delay_drift": Cause("timing", "rate_s_per_s", 1e-4, 0.004, ("rate_s_per_s",), signed=True),
    "stale_frame_buffer": Cause("timing", "frames", 1.0, 3.0, ("onset_s", "frames")),
    "clock_step": Cause("timing", "step_s", 0.01, 0.5, ("onset_s", "step_s"), signed=True),
}
"""Every cause of the contract. Smallest and largest departures are what this world calls physical."""

UNKNOWN: dict[str, tuple[float, float]] = {
    "bouc_wen_hysteresis": (0.001, 0.6),
    "wandering_gain": (0.002, 0.5),
    "asymmetric_stiffness": (0.0005, 0.4),
    "joint_eccentricity": (0.0005, 0.3),
    "aliased_gear_mesh": (0.005, 4.0),
    "correlated_bursts": (0.05, 20.0),
    "second_axis": (0.001, 0.5),
    "loose_mount": (0.001, 0.8),
    "viscoelastic_creep": (0.0005, 0.4),
    "pixel_locking": (0.005, 0.8),
    "gusts": (0.002, 3.0),
}
"""What the contract has no name for, with the range of its one number, `amount`."""


def wander(random: np.random.Generator, count: int, time_s: float, step_s: float) -> Array:
    """A slow random function: first-order Gauss-Markov, unit variance, correlation exp(-|t| / time_s)."""
    keep = float(np.exp(-step_s / time_s))
    white = random.standard_normal(count)
    white[0] /= np.sqrt(1.0 - keep * keep)
    out: Array = lfilter([np.sqrt(1.0 - keep * keep)], [1.0, -keep], white)
    return out


def rough_ramp(effect: Effect, time: Array, rate: float) -> Array:
    """rate x time; in the rough form it bends over (a thermal rise) and strays by a tenth of where it ends."""
    if effect.detail == 0.0 or len(time) < 2:
        return rate * time
    span = float(time[-1]) or 1.0
    bent = span * (1.0 - np.exp(-time / (2.0 * span))) / (1.0 - np.exp(-0.5))
    count = 400  # on a coarse grid, so that it is the same function at any sampling
    coarse = np.linspace(0.0, span, count)
    stray = wander(effect.chance(7), count, 0.15 * span, span / (count - 1))
    stray -= stray[0]
    smooth = np.interp(time, coarse, stray)
    out: Array = rate * (
        (1.0 - 0.5 * effect.detail) * time + 0.5 * effect.detail * bent + 0.06 * span * smooth
    )
    return out
