"""Moves the joint as the same dead time in [drive] would."""

from tests.fixtures.driven_joint import assert_moves_as_the_key


def test_the_joint_moves_as_with_the_key() -> None:
    assert_moves_as_the_key({"cause": "drive_dead_time", "dead_time_s": 0.0123}, {"dead_time_s": 0.0123})
