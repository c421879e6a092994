"""The filter bank: covariances stay covariances whatever happens."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fixtures.ringing_bank import act, check_covariances, ringing

actions = st.lists(
    st.tuples(
        st.sampled_from(
            ("block", "image", "arrival", "push", "step", "give", "end", "loosen", "place", "late", "anew")
        ),
        st.floats(-0.02, 0.02),
    ),
    min_size=5,
    max_size=60,
)


@pytest.mark.slow
@settings(max_examples=40, deadline=None, derandomize=True)
@given(course=actions)
def test_covariances_stay_symmetric_and_positive_semi_definite(course: list[tuple[str, float]]) -> None:
    """Any order of blocks, images, arrivals, changes of the force, and new beginnings."""
    filters, at = ringing()
    for action, size in course:
        act(filters, at, action, size)
        check_covariances(filters)
        assert np.isfinite(filters.x).all()
