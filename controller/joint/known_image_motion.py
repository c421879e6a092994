"""Rate of the known motion that is subtracted from the image: a dating error causes an error in proportion to it."""

from stillarm.controller.joint.joint_motion import JointMotion
from stillarm.controller.joint.sensor_deflection import SensorDeflection

_HALF_SPAN_S = 0.002  # two cycles: the drive's report is rounded to an encoder's count


def joint_image_rate_m_s(sensors: SensorDeflection, joint: JointMotion, time_s: float) -> float:
    """Rate of the image motion by the joint alone at an instant, m/s, in metres of the first mode."""
    before, after = joint.position_at(time_s - _HALF_SPAN_S), joint.position_at(time_s + _HALF_SPAN_S)
    return (sensors.of_image(0.0, before) - sensors.of_image(0.0, after)) / (2.0 * _HALF_SPAN_S)


def forced_rate_m_s(joint: JointMotion, time_s: float) -> float:
    """Rate of the first mode's response to the joint's motion at an instant, m/s."""
    before = joint.forced_deflection_at(time_s - _HALF_SPAN_S)
    return (joint.forced_deflection_at(time_s + _HALF_SPAN_S) - before) / (2.0 * _HALF_SPAN_S)
