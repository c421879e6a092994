"""The one picture that shows a finding: what betrays its cause, beside measured and simulated."""

from collections.abc import Callable

from stillarm.common.causes import CAUSES, Place
from stillarm.diagnosis.inference.laws import OF_STAMPS
from stillarm.diagnosis.report import panels, sensor_panels
from stillarm.diagnosis.report.case import ARM_CHANNELS, Case
from stillarm.diagnosis.report.drawing import Draw, svg

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


def picture(case: Case) -> str:
    """The picture of a finding as SVG."""
    assert case.finding is not None
    cause = case.finding.cause
    panel, channels = _TELLING.get(cause, _BY_PLACE[CAUSES[cause].place])
    if cause == "clock_step" and case.finding.note == OF_STAMPS:
        return svg(
            [sensor_panels.stamp_offsets(case, "displacement")], f"{cause}: stamps", panel_in=(7.0, 2.9)
        )
    if cause == "clock_step" and case.finding.law is not None:
        return svg([panels.residual_in_time(case, case.channels[0])], cause, panel_in=(9.0, 2.9))
    name = case.first_of(*channels)
    if name is None and panel is sensor_panels.arrivals and "displacement" in case.channels:
        panel, name = _BY_TIMING, "displacement"
    if case.finding.law is not None:
        name = name or case.channels[0]
        return svg([panel(case, name)], f"{cause}: {name}", panel_in=(7.5, 2.9))
    if name is None:  # what would betray it was not recorded
        panel, name = panels.residual_in_time, case.channels[0]
    shown = name if name != "arrival" and case.gain(name) > 0.2 * case.gain(case.channels[0]) else None
    shown = shown or next((one for one in case.channels if one != "arrival"), name)
    drawn: list[Draw] = [panel(case, name)]
    drawn.append(
        panels.overlay(case, shown) if shown != "arrival" else panels.residual_in_time(case, "arrival")
    )
    return svg(drawn, f"{cause}: what betrays it, and measured beside simulated")


def picture_of_all(case: Case, band_hz: tuple[float, float] | None, channel: str | None) -> str:
    """Where nothing was named: the channel with something left, or the one that shows the arm best."""
    name = channel or case.first_of(*ARM_CHANNELS) or case.channels[0]
    return svg(
        [panels.residual_spectrum(case, name, band_hz), panels.overlay(case, name)],
        f"{name}: spectrum of the residual, and measured beside simulated",
    )
