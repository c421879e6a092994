"""The one picture that shows a finding: what betrays its cause, beside measured and simulated."""

from collections.abc import Callable

from stillarm.common.causes import CAUSES, Place
from stillarm.diagnosis.report import panels, sensor_panels
from stillarm.diagnosis.report.case import ARM_CHANNELS, Case, cases, whole
from stillarm.diagnosis.report.drawing import Draw, Picture
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.sensors.laws import OF_STAMPS

Panel = Callable[[Case, str], Draw]


def _against(variable: str) -> Panel:
    return lambda case, name: panels.residual_against(case, name, variable)


_ARM, _JOINT = ARM_CHANNELS, ("joint_velocity", "joint_position")


_TELLING: dict[str, tuple[Panel, tuple[str, ...]]] = {
    "coulomb_damping": (panels.amplitude_in_time, _ARM),
    "quadratic_damping": (panels.amplitude_in_time, _ARM),
    "cubic_stiffness": (panels.frequency_against_amplitude, _ARM),
    "payload_change": (panels.frequency_in_time, _ARM),
    "stiffness_drift": (panels.frequency_in_time, _ARM),
    "drive_dead_time": (_against("joint acceleration"), _JOINT),
    "drive_lag": (_against("joint acceleration"), _JOINT),
    "drive_saturation": (sensor_panels.speed_against_command, _JOINT),
    "drive_deadband": (sensor_panels.speed_against_command, _JOINT),
    "joint_friction": (sensor_panels.speed_against_command, _JOINT),
    "gear_backlash": (_against("sign of the joint velocity"), ("joint_position", "displacement")),
    "accelerometer_sensitivity_drift": (sensor_panels.gain_in_time, ("acceleration",)),
    "accelerometer_clipping": (sensor_panels.measured_against_simulated, ("acceleration",)),
    "accelerometer_lag": (_against("speed of the deflection"), ("acceleration",)),
    "gravity_leakage": (_against("joint position"), ("acceleration",)),
    "mains_hum": (panels.residual_spectrum, ("acceleration",)),
    "impulse_noise": (sensor_panels.histogram, ("acceleration",)),
    "lens_distortion": (sensor_panels.measured_against_simulated, ("displacement",)),
    "camera_tilt_coupling": (_against("deflection"), ("displacement",)),
    "frame_drops": (sensor_panels.missing_frames, ("displacement",)),
    "stale_frame_buffer": (sensor_panels.image_lateness, ("displacement",)),
}


_BY_PLACE: dict[Place, tuple[Panel, tuple[str, ...]]] = {
    "arm": (panels.residual_spectrum, _ARM),
    "drive": (panels.residual_spectrum, _ARM),
    "accelerometer": (_against("time"), ("acceleration",)),
    "camera": (_against("time"), ("displacement",)),
    "timing": (sensor_panels.arrivals, ("arrival",)),
}


_BY_TIMING: Panel = sensor_panels.image_lateness


def picture(case: Case) -> Picture:
    """The picture of a finding."""
    assert case.finding is not None
    cause = case.finding.cause
    panel, channels = _TELLING.get(cause, _BY_PLACE[CAUSES[cause].place])
    if cause == "clock_step" and case.finding.note == OF_STAMPS:
        return Picture([sensor_panels.stamp_offsets(case, "displacement")], f"{cause}: stamps", (7.0, 2.9))
    if cause == "clock_step" and case.finding.law is not None:
        return Picture([panels.residual_in_time(case, case.channels[0])], cause, (9.0, 2.9))
    name = case.first_of(*channels)
    if name is None and panel is sensor_panels.arrivals and "displacement" in case.channels:
        panel, name = _BY_TIMING, "displacement"
    if case.finding.law is not None:
        name = name or case.channels[0]
        return Picture([panel(case, name)], f"{cause}: {name}", (7.5, 2.9))
    if name is None:  # what would betray it was not recorded
        panel, name = panels.residual_in_time, case.channels[0]
    shown = name if name != "arrival" and case.gain(name) > 0.2 * case.gain(case.channels[0]) else None
    shown = shown or next((one for one in case.channels if one != "arrival"), name)
    drawn: list[Draw] = [panel(case, name)]
    drawn.append(
        panels.overlay(case, shown) if shown != "arrival" else panels.residual_in_time(case, "arrival")
    )
    return Picture(drawn, f"{cause}: what betrays it, and measured beside simulated")


def picture_of_all(result: Result) -> Picture:
    """Baseline beside end: the channel with something left that has no name, or the one that shows the arm best."""
    case, left = whole(result), result.table["unexplained"]
    if left is not None and left["channel"] == "arrival":
        return Picture([sensor_panels.arrivals(case, "arrival")], "arrivals", (7.5, 2.9))
    name = left["channel"] if left is not None else case.first_of(*ARM_CHANNELS) or case.channels[0]
    band_hz = (left["band_hz"][0], left["band_hz"][1]) if left is not None else None
    return Picture(
        [panels.residual_spectrum(case, name, band_hz), panels.overlay(case, name)],
        f"{name}: spectrum of the residual, and measured beside simulated",
    )


def main_picture(result: Result, finding: int = 0) -> Picture:
    """The evidence for a finding, by its number; where there is none, or what is left has no name, for that."""
    told = list(cases(result))
    if result.table["verdict"] == "named":
        return picture(told[finding])
    return picture_of_all(result)


__all__ = ["main_picture", "picture", "picture_of_all"]
