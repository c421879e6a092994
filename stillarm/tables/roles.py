"""What a channel may be in a recording. A role's name carries its unit; docs/import.md lists them."""

from dataclasses import dataclass

INPUT, OUTPUT = "input", "output"
UNKNOWN, IGNORE = "unknown", "ignore"
STRAIN = "strain"


@dataclass(frozen=True)
class Role:
    """name: as in the description. dimension: SI unit as the name's suffix writes it; "" where any unit will do.

    topic: where its values go. about: in words.
    """

    name: str
    dimension: str
    topic: str
    about: str


ROLES = (
    Role("acceleration_m_s2", "m_s2", "/fast", "of the tip"),
    Role("joint_velocity_command_rad_s", "rad_s", "/fast", "what the drive was sent"),
    Role("joint_velocity_reference_rad_s", "rad_s", "/fast", "the external part of the command"),
    Role("joint_position_rad", "rad", "/fast", "angle of the joint"),
    Role("joint_velocity_rad_s", "rad_s", "/fast", "velocity of the joint"),
    Role("deflection_m", "m", "/fast", "of the tip, measured directly"),
    Role("joint_torque_n_m", "n_m", "/fast", "as measured"),
    Role("joint_torque_command_n_m", "n_m", "/fast", "what the drive was told"),
    Role("motor_current_a", "a", "/fast", "as measured"),
    Role("motor_current_command_a", "a", "/fast", "what the amplifier was told"),
    Role("motor_voltage_v", "v", "/fast", "at the motor, or what the amplifier was told"),
    Role("motor_position_rad", "rad", "/fast", "angle of the motor, before the gear"),
    Role(
        STRAIN,
        "",
        "/fast",
        "a strain gauge in any unit: grows with the deflection, by a scale that is fitted",
    ),
    Role("displacement_px", "px", "/frames", "of the scene, along the image's x axis"),
    Role("displacement_y_px", "px", "/frames", "along its y axis"),
    Role("rotation_rad", "rad", "/frames", "of the scene"),
    Role("frame", "", "/frames", "counts exposures or arrivals"),
    Role("started_s", "s", "/frames", "n_i * cycle_s"),
    Role("captured_s", "s", "/frames", "the camera's own stamp"),
    Role("exposure_s", "s", "/frames", "exposure time"),
    Role(INPUT, "", "/pair", "of a pair of unknown physics"),
    Role(OUTPUT, "", "/pair", "of a pair of unknown physics"),
    Role(UNKNOWN, "", "/fast/columns", "kept under its own name"),
    Role(IGNORE, "", "", "left out"),
)
BY_NAME = {role.name: role for role in ROLES}
