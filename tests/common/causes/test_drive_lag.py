"""Moves the joint as the same bandwidth in [drive] would."""

from tests.fixtures.driven_joint import assert_moves_as_the_key


def test_the_joint_moves_as_with_the_key() -> None:
    assert_moves_as_the_key({"cause": "drive_lag", "bandwidth_hz": 5.0}, {"bandwidth_hz": 5.0})
