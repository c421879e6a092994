"""The M-estimator: exact without noise, unmoved by outliers, its covariance of the errors' size."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.supervisor.tracking.matching.rigid_displacement import fit_rigid


def rigid(points, dx, dy, rotation):
    c, s = np.cos(rotation), np.sin(rotation)
    return points @ np.array([[c, -s], [s, c]]).T + [dx, dy]


@settings(max_examples=100, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(20, 150),
    share=st.floats(0.0, 0.3),
    dx=st.floats(-300, 300),
    dy=st.floats(-300, 300),
    rotation=st.floats(-3.0, 3.0),
)
def test_outliers_do_not_move_it(seed, count, share, dx, dy, rotation):
    random = np.random.default_rng(seed)
    points = random.uniform(-250, 250, (count, 2))
    moved = rigid(points, dx, dy, rotation) + random.normal(0, 0.05, points.shape)
    outliers = random.choice(count, int(share * count), replace=False)
    moved[outliers] += random.uniform(3, 60, (len(outliers), 2)) * random.choice([-1, 1], (len(outliers), 2))
    fit = fit_rigid(points, moved)
    assert fit is not None
    assert abs(fit.dx - dx) < 0.15 and abs(fit.dy - dy) < 0.15 and abs(fit.rotation - rotation) < 1.5e-3
    assert (fit.weights[outliers] < 0.1).all()


def test_a_group_that_moves_together_is_rejected():
    random = np.random.default_rng(0)
    points = random.uniform(-250, 250, (100, 2))
    moved = points + np.array([1.3, -0.4]) + random.normal(0, 0.05, points.shape)
    moved[:35] += [6.0, 0.0]
    fit = fit_rigid(points, moved)
    assert fit is not None
    assert abs(fit.dx - 1.3) < 0.03 and abs(fit.dy + 0.4) < 0.03
    assert fit.inliers >= 55


def test_covariance_matches_the_scatter_of_many_fits():
    random = np.random.default_rng(1)
    off_centre = np.array([80.0, 0.0])  # so that rotation and displacement couple
    points = off_centre + random.uniform(-250, 250, (60, 2))
    fits = [fit_rigid(points, points + random.normal(0, 0.1, points.shape)) for _ in range(400)]
    scatter = np.cov(np.array([(f.dx, f.dy, f.rotation) for f in fits]).T)
    stated = np.mean([f.covariance for f in fits], axis=0)
    ratio = np.sqrt(np.diag(scatter) / np.diag(stated))
    assert (ratio > 0.8).all() and (ratio < 1.25).all()
    coupling = [m[1, 2] / np.sqrt(m[1, 1] * m[2, 2]) for m in (scatter, stated)]
    assert coupling[0] * coupling[1] > 0 and abs(coupling[0] - coupling[1]) < 0.15


def test_too_few_or_coincident_points_give_none():
    assert fit_rigid(np.zeros((2, 2)), np.zeros((2, 2))) is None
    assert fit_rigid(np.zeros((10, 2)), np.ones((10, 2))) is None
