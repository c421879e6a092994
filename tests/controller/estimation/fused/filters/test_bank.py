"""The filter bank: covariances stay covariances whatever happens."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.controller.estimation.fused.filters.bank import FilterBank
from tests.fixtures.ringing_bank import act, ringing


def check_covariances(filters: FilterBank) -> None:
    """Symmetric, and no direction has a negative variance; measured in the states' own first deviations."""
    scale = np.sqrt(filters.first + 1e-12)
    for one, unit in zip(filters.p, scale, strict=True):
        relative = one / unit[:, None] / unit
        assert np.allclose(relative, relative.T, rtol=1e-6, atol=1e-9)
        assert np.linalg.eigvalsh(0.5 * (relative + relative.T)).min() > -1e-8


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


@settings(max_examples=40, deadline=None, derandomize=True)
@given(course=actions)
def test_covariances_stay_symmetric_and_positive_semi_definite(course: list[tuple[str, float]]) -> None:
    """Any order of blocks, images, arrivals, changes of the force, and new beginnings."""
    filters, at = ringing()
    for action, size in course:
        act(filters, at, action, size)
        check_covariances(filters)
        assert np.isfinite(filters.x).all()
