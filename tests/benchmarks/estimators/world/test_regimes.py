"""Regimes by their names."""

import pytest

from stillarm.benchmarks.estimators.world.regimes import (
    regimes_named,
)
from stillarm.common.user_error import UserError


def test_an_unknown_regime_is_refused() -> None:
    """In one line that names what there is."""
    with pytest.raises(
        UserError, match=r"regime 'slow': unknown; use one of freerun constant, .*stamped jitter, live$"
    ):
        regimes_named(["slow"])
