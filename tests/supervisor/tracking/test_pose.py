"""Poses and their sums."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stillarm.supervisor.tracking.pose import Pose, pose_since, total_pose


@given(*(st.floats(-500, 500) for _ in range(4)), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_pose_since_undoes_total_pose(x, y, u, v, a, b):
    key, since = Pose(x, y, a), Pose(u, v, b)
    back = pose_since(key, total_pose(key, since))
    assert np.allclose(back, since, atol=1e-9)


@given(st.floats(0.01, 0.5), st.integers(1, 12))
def test_along_an_arc_the_sum_is_the_arc_s_length(angle, keys):
    radius = 1600.0
    step = angle / keys
    pose = Pose(0.0, 0.0, 0.0)
    for _ in range(keys):  # in the present's axes the chord leans forward by half the angle
        chord = 2 * radius * np.sin(step / 2)
        pose = total_pose(pose, Pose(chord * np.cos(step / 2), chord * np.sin(step / 2), step))
    assert abs(pose.x - radius * angle) < radius * angle * angle**2 / 20 + 1e-9
    assert abs(pose.y) < 1e-6
