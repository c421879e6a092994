"""How fast the image moves by what is taken off it: a wrong capture instant makes an error of this rate."""

from controller.joint_motion import JointMotion
from controller.sensor_deflection import SensorDeflection

_HALF_SPAN_S = 0.002  # two cycles: the drive's report is rounded to an encoder's count


def joint_image_rate_m_s(sensors: SensorDeflection, joint: JointMotion, time_s: float) -> float:
    """Rate at which the joint alone moves the image at an instant, m/s, in metres of the first mode."""
    before, after = joint.position_at(time_s - _HALF_SPAN_S), joint.position_at(time_s + _HALF_SPAN_S)
    return (sensors.of_image(0.0, before) - sensors.of_image(0.0, after)) / (2.0 * _HALF_SPAN_S)


def forced_rate_m_s(joint: JointMotion, time_s: float) -> float:
    """Rate at an instant of the first mode's answer to the joint's motion."""
    before = joint.forced_deflection_at(time_s - _HALF_SPAN_S)
    return (joint.forced_deflection_at(time_s + _HALF_SPAN_S) - before) / (2.0 * _HALF_SPAN_S)
