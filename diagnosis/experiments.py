"""What to record next to tell causes apart that the data cannot."""

from diagnosis.world import World

_KNOWN: dict[frozenset[str], str] = {
    frozenset(("joint_friction", "drive_deadband")): (
        "reverse the joint slowly several times, at speeds from a tenth of to three times the smallest speed it obeys: "
        "a dead band stops below one speed and loses nothing above it, friction loses the same at every speed"
    ),
    frozenset(("accelerometer_lag", "drive_dead_time")): (
        "record the joint's encoder (joint_position_rad) while the joint moves: it shows the drive without the sensor"
    ),
    frozenset(("accelerometer_lag", "drive_lag")): (
        "record the joint's encoder (joint_position_rad) while the joint moves: it shows the drive without the sensor"
    ),
    frozenset(("drive_lag", "drive_dead_time")): (
        "command steps and fast reversals of the joint's velocity, and record joint_velocity_rad_s: a dead time shifts "
        "the answer, a lag rounds it"
    ),
    frozenset(("camera_clock_skew", "delay_drift")): (
        "record with the accelerometer or the camera's stamps, or move the joint throughout: the images' content then "
        "tells when they were taken"
    ),
    frozenset(("stale_frame_buffer", "clock_step")): (
        "record with the camera's stamps (captured_s) or its counter of exposures: a stale buffer shifts the content, "
        "a clock step the arrival"
    ),
    frozenset(("gear_backlash", "cubic_stiffness")): (
        "make small moves to and fro, of the size of the gap: play depends on the reversal, stiffness on the deflection"
    ),
    frozenset(("tracking_drift", "accelerometer_bias_drift")): (
        "revisit the same pose at the beginning, in the middle and at the end: a sag comes "
        "back with the pose, a drift does not"
    ),
    frozenset(("accelerometer_sensitivity_drift", "quadratic_damping")): (
        "record the camera too, or strike the arm equally hard at the beginning and at the end"
    ),
}

_BY_PLACE = {
    "arm": "let the arm ring down freely with damping off, from a large and from a small deflection",
    "drive": "move the joint at several speeds with quick and slow reversals, and record "
    "joint_position_rad and joint_velocity_rad_s",
    "accelerometer": "record a rest of ten seconds, a ring-down and a move in one recording, with the camera",
    "camera": "move the joint rigidly and slowly through its whole range and back to the same pose twice",
    "timing": "record with the camera's stamps, and move the joint throughout",
}


def experiment(cause: str, near: list[str], world: World) -> str:
    """The recording that separates a cause from those that explain the data as well."""
    from common.causes import CAUSES

    for other in near:
        known = _KNOWN.get(frozenset((cause, other)))
        if known:
            return known
    place = CAUSES[cause].place
    return _BY_PLACE[place]
