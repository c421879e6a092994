"""The arm's deflection by each sensor, after the joint's own motion is subtracted."""

from math import sin

from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.model import Camera, Mode, Model
from stillarm.controller.joint.joint_motion import JointMotion


def shown_of(mode: Mode, camera: Camera) -> float:
    """What an image shows of a vibration: its mean over the exposure T, sin(w T / 2) / (w T / 2) of mid-exposure's."""
    half_rad = 0.5 * mode.angular_frequency * camera.exposure_s
    return sin(half_rad) / half_rad if half_rad else 1.0


class SensorDeflection:
    """The contract's sensor equations solved for the deflection of the first mode."""

    def __init__(self, model: Model, length_m: float) -> None:
        """Use the model's scales and participations."""
        w = model.arm.modes[0].angular_frequency
        slope = tip_slopes_per_m(length_m, 1)[0]
        camera, accelerometer = model.camera, model.accelerometer
        shown = shown_of(model.arm.modes[0], camera)
        self._per_px = -1.0 / (camera.scale_px_per_m + camera.rotation_px_per_rad * slope) / shown
        self._px_per_rad = camera.scale_px_per_m * length_m + camera.rotation_px_per_rad
        self._per_acceleration = -1.0 / (w * w)
        self._scale = accelerometer.scale
        self._bias = accelerometer.bias_m_s2
        self._rigid_share = (1.0 - sum(mode.participation for mode in model.arm.modes)) * length_m
        self.noise_std_m = abs(self._per_px) * camera.noise_std_px

    def of_image(self, displacement_px: float, joint_position_rad: float) -> float:
        """Deflection plus an unknown constant, m, from the image and the joint position at its capture instant."""
        return (displacement_px + self._px_per_rad * joint_position_rad) * self._per_px

    def of_acceleration(self, acceleration_m_s2: float, joint: JointMotion) -> float:
        """Deflection, ahead by 2 zeta / w, m, from the acceleration and the drive model's theta''; NaN gives NaN."""
        of_tip = (acceleration_m_s2 - self._bias) / self._scale
        return self._per_acceleration * (of_tip - self._rigid_share * joint.acceleration_rad_s2)
