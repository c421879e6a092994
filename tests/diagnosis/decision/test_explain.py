"""The rounds of the search on recordings made by the simulation itself: statistics, not physics."""

import pytest

from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.inference.candidates import Found
from tests.fixtures.synthetic import fitted, measured

SECONDS = 20.0


def _explained(values: dict[str, float], *only: str) -> Found:
    baseline = fitted(measured(SECONDS, 5, values))
    return explain(baseline, interleaved(SECONDS), only=only)


def test_nothing_is_found_where_nothing_is_hidden() -> None:
    found = _explained(
        {}, "cubic_stiffness", "tracking_drift", "mains_hum", "accelerometer_lag", "joint_friction"
    )
    assert [one.cause for one in found.findings] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("quantity", "value", "cause"),
    [
        ("camera.rate_px_per_s", 0.1, "tracking_drift"),
        ("accelerometer.gravity_m_s2_per_rad", 5.0, "gravity_leakage"),
        ("arm.cubic_per_m2", 10.0, "cubic_stiffness"),
    ],
)
def test_the_hidden_cause_comes_first(quantity: str, value: float, cause: str) -> None:
    found = _explained(
        {quantity: value}, "tracking_drift", "gravity_leakage", "cubic_stiffness", "lens_distortion"
    )
    assert found.findings[0].cause == cause
    assert found.final.value(quantity) == pytest.approx(value, rel=0.1) or found.findings[0].form


def test_a_cause_that_is_not_looked_for_is_not_found() -> None:
    found = _explained({"camera.rate_px_per_s": 0.1}, "cubic_stiffness")
    assert "tracking_drift" not in [one.cause for one in found.findings]
