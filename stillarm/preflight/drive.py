"""Checks the drive: its presence, reports, identity and torque. Nothing is armed, and only zero is commanded."""

from math import isnan

from stillarm.common.files.configuration import DriveDevice
from stillarm.common.files.driven_joint import commanded_joint
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import DriveProbe
from stillarm.preflight.verdict import Verdict, fail, ok, warn

_FEWEST_PER_S = 20.0


def judge_drive(probe: DriveProbe, config: DriveDevice, model: Model) -> list[Verdict]:
    """Judge the answers of a drive."""
    rate = probe.reports / max(probe.span_s, 1e-9)
    verdicts = [ok("drive", f"{probe.identity} answers")]
    if rate < _FEWEST_PER_S and config.driver != "cia402":
        verdicts.append(
            fail(
                "drive",
                f"{rate:.0f} answers a second: a lost drive could not be detected within 50 ms; check cable and baud",
            )
        )
    limits = model.drive
    if not isnan(probe.position_rad):
        inside = limits.min_position_rad <= probe.position_rad <= limits.max_position_rad
        text = f"joint at {probe.position_rad:+.3f} rad"
        span = f"{limits.min_position_rad:g} to {limits.max_position_rad:g} rad"
        verdicts.append(
            ok("drive", text)
            if inside
            else fail(
                "drive",
                f"{text}, outside the model's {span}: move it back by hand, home the encoder, or correct "
                "drive.gear_ratio",
            )
        )
    fatal = ("fault", "error", "EEPROM")
    for note in probe.notes:
        verdicts.append((fail if any(word in note for word in fatal) else warn)("drive", note))
    return verdicts


def judge_torque(model: Model, name: str) -> list[Verdict]:
    """Whether the input that a drive may have turns the joint as fast as the model says; nothing of a joint that
    follows velocities. `name` stands for the model's file."""
    try:
        joint = commanded_joint(model, name)
        if joint is None:
            return []
        largest = joint.most_n_m(name)
    except UserError as error:
        return [fail("drive", str(error))]
    drive, inertia = model.drive, joint.inertia_kg_m2
    rubs = joint.damping_n_m_s * drive.max_velocity_rad_s + joint.coulomb_n_m
    asked, fastest = inertia * drive.max_acceleration_rad_s2 + rubs, (largest - rubs) / inertia
    gives = f"drive.input_limit = {drive.input_limit:g} gives {largest:.3g} N m"
    if fastest <= 0.0:
        takes = f"friction at {drive.max_velocity_rad_s:g} rad/s alone takes {rubs:.3g} N m"
        remedy = "raise it as far as the drive allows, or lower drive.max_velocity_rad_s"
        return [fail("drive", f"{gives}, and {takes}: {remedy}")]
    if largest < asked:
        takes = f"{drive.max_acceleration_rad_s2:g} rad/s^2 at {drive.max_velocity_rad_s:g} rad/s needs {asked:.3g}"
        remedy = f"raise it as far as the drive allows, or drive.max_acceleration_rad_s2 = {fastest:.2g}"
        return [warn("drive", f"{gives}, and {takes}: {remedy}")]
    return [ok("drive", f"{gives} of {asked:.3g} that the model's accelerations need")]
