"""Which forms of an effect have the parameters of the contract's formula, so that what is told can be compared."""

from tests.hidden_world.rigs.rig import Effect

_COURSES = ("sqrt", "exponential", "random_walk", "bent", "path", "steps_with_reset")
"""A drift that takes another course than a line has no rate: the truth tells its mean."""

_OF_ANOTHER_LAW: dict[str, tuple[str, ...]] = {
    "stiffness_drift": _COURSES,
    "periodic_disturbance": ("wandering_phase",),
    "drive_lag": ("second_pole", "speeding_up"),
    "drive_deadband": ("hysteretic",),
    "accelerometer_bias_drift": _COURSES,
    "accelerometer_sensitivity_drift": _COURSES,
    "accelerometer_clipping": ("soft",),
    "mains_hum": ("swelling",),
    "impulse_noise": ("exponential", "two_samples"),
    "tracking_drift": _COURSES,
    "lens_distortion": ("fifth_order",),
    "camera_clock_skew": ("warming",),
    "frame_drops": ("runs",),
    "delay_bursts": ("varied", "draining"),
    "delay_drift": _COURSES,
}
_OF_THE_WHOLE_RECORDING = ("frame_drops", "delay_bursts", "delay_drift")
"""Their formulas know no onset."""
_POWER = 2.0


def comparable(effect: Effect) -> bool:
    """Whether the parameters that the truth tells are those of the formula."""
    if effect.form in _OF_ANOTHER_LAW.get(effect.cause, ()):
        return False
    if effect.cause == "quadratic_damping":  # another power gives the coefficient another unit
        return effect.extras["power"] == _POWER
    return effect.onset_s == 0.0 or effect.cause not in _OF_THE_WHOLE_RECORDING
