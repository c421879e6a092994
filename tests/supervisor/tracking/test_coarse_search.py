"""The coarse search against its definition, worked out shift by shift."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.supervisor.tracking.coarse_search import MIN_COMMON, coarse_shift, coarse_view, overlap_score


@pytest.mark.slow
@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    height=st.integers(16, 24),
    width=st.integers(16, 30),
    x=st.integers(-12, 12),
    y=st.integers(-10, 10),
)
def test_the_best_of_all_shifts(seed, height, width, x, y):
    random = np.random.default_rng(seed)
    scene = random.normal(128.0, 40.0, (60, 70)).astype(np.float32)
    before = scene[20 : 20 + height, 20 : 20 + width]
    image = scene[20 - y : 20 - y + height, 20 - x : 20 - x + width]
    image = image + random.normal(0.0, 20.0, image.shape).astype(np.float32)
    found = coarse_shift(coarse_view(before), coarse_view(image))
    scores = {
        (u, v): overlap_score(before, image, u, v)
        for u in range(-width + 1, width)
        for v in range(-height + 1, height)
        if (width - abs(u)) * (height - abs(v)) >= MIN_COMMON * width * height
    }
    assert abs(found.score - max(scores.values())) < 1e-4
    assert abs(scores[found.x, found.y] - found.score) < 1e-4
    if (width - abs(x)) * (height - abs(y)) > 0.4 * width * height:
        assert (found.x, found.y) == (x, y)


def test_images_without_any_contrast_score_nothing():
    flat = np.full((40, 50), 128.0, np.float32)
    assert coarse_shift(coarse_view(flat), coarse_view(flat)).score == -1.0
    assert overlap_score(flat, flat, 0, 0) == -1.0
