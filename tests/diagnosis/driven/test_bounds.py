"""Sizes that no rig has, and those that only look odd."""

import pytest

from stillarm.diagnosis.driven.bounds import LONGEST_DELAY_S, believable


@pytest.mark.parametrize(
    ("names", "numbers", "is_so"),
    [
        (("gap", "share"), {"gap": 0.01, "share": 0.3}, True),
        (("gap", "share"), {"gap": 0.05, "share": 0.0201}, False),  # a motor without inertia
        (("inertia_excess",), {"inertia_excess": 1.5}, True),
        (("inertia_excess",), {"inertia_excess": 9.9}, False),
        (("delay strain",), {"delay strain": 0.02}, True),
        (("delay strain",), {"delay strain": -0.0001}, False),  # a hundredth of a sample
        (("lag strain",), {"lag strain": 0.0004}, False),
        (("delay", "late"), {"delay": LONGEST_DELAY_S, "late": 1.0}, False),
        (("inertia_excess @1",), {"inertia_excess @1": -0.8}, False),
        (("coulomb",), {"coulomb": 1e6}, True),  # no bound is known: the data decide
    ],
)
def test_a_size_at_a_bound_is_not_believed(
    names: tuple[str, ...], numbers: dict[str, float], is_so: bool
) -> None:
    assert believable(names, numbers, 0.01) is is_so
