"""Checks the drive: its presence, reports and identity. Nothing is armed, and only zero is commanded."""

from math import isnan

from stillarm.common.files.configuration import DriveDevice
from stillarm.common.files.model import Model
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
