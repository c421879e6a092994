"""Plans of odd values, drawn with hypothesis: every field, singly and together, and pauses."""

from math import inf, nan
from typing import Any

from hypothesis import strategies as st

from stillarm.benchmarks.fuzz.odd_world import Odd, Plan
from stillarm.common.datagrams.visual_sample import TrackingStatus

_FAR = (nan, inf, -inf, 1e308, -1e308, 1e300, -1e300, 1e18, -1e18, float(2**40), -float(2**63))
_WHOLE = (-(2**63), -(2**40), -2, 2**31, 2**32, 2**40, 2**53 + 1, 2**62, 2**63 - 1, 2**64, 10**400)
CYCLE_FLOATS = (
    "acceleration_m_s2",
    "joint_position_rad",
    "joint_velocity_rad_s",
    "joint_age_s",
    "reference_rad_s",
    "deflection_m",
)
SAMPLE_FLOATS = (
    "displacement_x_px",
    "displacement_y_px",
    "rotation_rad",
    "variance_x_px2",
    "variance_y_px2",
    "covariance_xy_px2",
    "variance_rotation_rad2",
    "captured_s",
    "exposure_s",
)
WHOLE_FIELDS = ("cycle", "operator", "frame", "started_cycle", "status", "features", "inliers")

far_floats = st.sampled_from((*_FAR, 10**400)) | st.integers(6, 307).flatmap(
    lambda power: st.sampled_from((10.0**power, -(10.0**power)))
)
wholes = (
    st.sampled_from(_WHOLE)
    | st.integers(24, 1200).flatmap(lambda bits: st.integers(-(2**bits), 2**bits))
    | far_floats
)
pauses = st.integers(0, 6).flatmap(lambda power: st.integers(1, 10**power))
_SPANNED: dict[str, st.SearchStrategy[Any]] = {
    "acceleration_m_s2": st.floats(40.0, 1e6),
    "joint_position_rad": st.floats(0.15, 100.0),
    "displacement_x_px": st.floats(250.0, 1e5),
    "captured_s": st.floats(-1e6, 1e6),
    "variance_x_px2": st.floats(0.0, 1e9),
    "frame": st.integers(0, 10**6),
    "started_cycle": st.integers(0, 10**4),
}
"""Values just beyond the plausible range, or within the range that the estimators must tolerate."""
_SPECIAL: dict[str, st.SearchStrategy[Any]] = {
    # displacements near zero are plausible; the estimators have to judge them
    "displacement_x_px": far_floats,
    "status": st.sampled_from([int(one) for one in TrackingStatus]) | wholes,
    "restarted": st.just(True),
    "damping_allowed": st.sampled_from((nan, inf, 2**40, -1, None)),
    "samples": st.integers(2, 60),
    "pause": pauses,
}


def values(field: str) -> st.SearchStrategy[Any]:
    """Odd values of a field."""
    whole = field not in CYCLE_FLOATS and field not in SAMPLE_FLOATS
    usual = wholes if whole else far_floats | st.sampled_from((5e-324, -0.0))
    far = _SPECIAL.get(field, usual)
    return far | _SPANNED[field] if field in _SPANNED else far


FIELDS = (*CYCLE_FLOATS, *SAMPLE_FLOATS, *WHOLE_FIELDS, "damping_allowed", "restarted", "samples", "pause")


@st.composite
def odds(draw: st.DrawFn) -> Odd:
    """One odd value, for some cycles."""
    name = draw(st.sampled_from(FIELDS))
    times = 1 if name == "pause" else draw(st.sampled_from((1, 1, 2, 5, 30)))
    return Odd(draw(st.integers(0, 400)), name, draw(values(name)), times)


def plans() -> st.SearchStrategy[Plan]:
    """Plans with up to six odd values of any fields."""
    return st.builds(Plan, st.lists(odds(), min_size=1, max_size=6).map(tuple), st.booleans())
