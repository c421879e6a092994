"""Laws without a name: what they do, and that no model file and no report may hold one."""

import pytest

from stillarm.common.causes import CAUSES, LAWS, RIVALS
from stillarm.common.causes.rivals import one_sided


@pytest.mark.parametrize("at_m", [0.004, -0.004])
def test_a_one_sided_stiffness_acts_beyond_its_deflection_alone(at_m: float) -> None:
    def force(q: float) -> float:
        return one_sided(0.0, 0.0, 0.0, q, 0.0, 10.0, 0.5, at_m)

    assert force(at_m) == 0.0 and force(-10.0 * at_m) == 0.0
    assert force(at_m * 1.5) == pytest.approx(-0.5 * 100.0 * 0.5 * at_m)


def test_laws_are_causes_and_rivals_and_no_rival_is_a_cause() -> None:
    assert not RIVALS.keys() & CAUSES.keys()
    assert LAWS == CAUSES | RIVALS
