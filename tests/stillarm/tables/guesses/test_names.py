"""Names as people write them."""

import pytest

from stillarm.tables.guesses.names import sense_of


@pytest.mark.parametrize(
    ("name", "quantity", "kind", "unit"),
    [
        ("joint_velocity_command_rad_s", "angular velocity", "command", "rad/s"),
        ("theta1 [deg]", "angle", "", "deg"),
        ("thetaDot (rad/s)", "angular velocity", "", "rad/s"),
        ("q_des", "angle", "command", ""),
        ("tau_meas", "torque", "measured", ""),
        ("i_motor_mA", "current", "", "ma"),
        ("motor_voltage", "voltage", "", ""),
        ("accX", "acceleration", "", ""),
        ("imu.linear_acceleration.x", "acceleration", "", ""),
        ("position.shoulder", "angle", "", ""),
        ("strain_gauge_1", "strain", "", ""),
        ("tip_deflection_mm", "deflection", "", "mm"),
        ("time_ms", "time", "", "ms"),
        ("mid_exposure_s", "time", "", "s"),
        ("theta_m", "angle", "", ""),
        ("V1", "unknown", "", ""),
        ("column 3", "unknown", "", ""),
        ("y", "unknown", "", ""),
    ],
)
def test_a_name_says(name: str, quantity: str, kind: str, unit: str) -> None:
    sense = sense_of(name)
    assert (sense.quantity, sense.kind, sense.unit.lower()) == (quantity, kind, unit.lower())


def test_a_letter_that_is_no_unit_names_the_part() -> None:
    assert sense_of("theta_m").part == "motor"


def test_a_unit_that_contradicts_a_word_wins() -> None:
    assert sense_of("motor speed [rad]").quantity == "angle"
    assert sense_of("position [m]").quantity == "unknown"
