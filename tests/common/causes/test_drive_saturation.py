"""Moves the joint as the same limit in [drive] would."""

from tests.fixtures.driven_joint import assert_moves_as_the_key


def test_the_joint_moves_as_with_the_key() -> None:
    assert_moves_as_the_key(
        {"cause": "drive_saturation", "max_velocity_rad_s": 0.08}, {"max_velocity_rad_s": 0.08}
    )
