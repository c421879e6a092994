"""The simulated rig's true motion as messages for the truth file: for scoring, never for replay or diagnosis."""

from typing import TYPE_CHECKING

from stillarm.common.files.scenario import Strike
from stillarm.common.recording.topics import LogLine, TrueState

if TYPE_CHECKING:
    from stillarm.simulation.arm.plant import Plant

STRIKE = "strike"


def true_state(plant: "Plant", time_s: float) -> TrueState:
    """The plant's state, at a time of the rig's clock."""
    return TrueState(
        time_s,
        plant.joint_position_rad,
        plant.joint_velocity_rad_s,
        plant.joint_acceleration_rad_s2,
        plant.deflection_m,
        plant.tip_position_m,
        plant.tip_acceleration_m_s2,
        plant.modal_deflections_m,
    )


def strike_line(strike: Strike, time_s: float) -> LogLine:
    """The note of an impact, at a time of the rig's clock."""
    return LogLine(time_s, "info", f"{STRIKE} of mode {strike.mode}, {strike.deflection_m} m")
