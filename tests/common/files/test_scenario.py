"""Scenarios: the reference that their moves make, when damping is allowed, what is refused."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.scenario import Move, Scenario, Window, load_scenario
from stillarm.common.user_error import UserError

MOVE = Move(start_s=1.0, end_s=2.0, velocity_rad_s=-0.4, ramp_s=0.1)


@pytest.mark.parametrize(
    ("time_s", "expected"), [(0.99, 0.0), (1.0, 0.0), (1.05, -0.2), (1.5, -0.4), (1.975, -0.1), (2.0, 0.0)]
)
def test_a_move_has_ramps_at_both_ends(time_s: float, expected: float) -> None:
    assert Scenario(moves=[MOVE]).reference_rad_s(time_s) == pytest.approx(expected, abs=1e-12)


def test_moves_add_up_and_need_no_ramp() -> None:
    step = Move(start_s=1.4, end_s=1.6, velocity_rad_s=1.0, ramp_s=0.0)
    assert Scenario(moves=[MOVE, step]).reference_rad_s(1.4) == pytest.approx(0.6)


@settings(deadline=None)
@given(st.floats(0, 3), st.floats(0.001, 2))
def test_the_reference_never_exceeds_its_velocity(time_s: float, ramp_s: float) -> None:
    move = Move(start_s=1.0, end_s=2.0, velocity_rad_s=0.4, ramp_s=ramp_s)
    assert 0.0 <= Scenario(moves=[move]).reference_rad_s(time_s) <= 0.4


def test_damping_windows_hold_their_start_and_not_their_end() -> None:
    scenario = Scenario(damping=[Window(1.0, 2.0), Window(3.0, 4.0)])
    assert [scenario.damping_allowed(t) for t in (0.5, 1.0, 1.5, 2.0, 3.5, 4.0)] == [
        *(False, True, True, False),
        *(True, False),
    ]
    assert not Scenario().damping_allowed(0.0)


def test_the_demo_rings_freely_before_it_is_damped() -> None:
    demo = load_scenario("demo")
    assert len(demo.strikes) == 2
    assert not demo.damping_allowed(demo.strikes[0].time_s) and demo.damping_allowed(demo.strikes[1].time_s)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[[moves]]\nstart_s = 2.0\nend_s = 1.0\nvelocity_rad_s = 1.0", r"moves\[0\]"),
        ("[[damping]]\non_s = 0.0\noff_s = 1.0\n[[damping]]\non_s = 1.0\noff_s = 1.0", r"damping\[1\]"),
        ("[[strikes]]\ntime_s = -1.0\ndeflection_m = 0.1", r"strikes\[0\].time_s = -1.0"),
        ("duration_s = 0.0", "duration_s = 0.0"),
    ],
)
def test_refusals(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "s.toml"
    path.write_text(text)
    with pytest.raises(UserError, match=expected) as refused:
        load_scenario(path)
    assert "\n" not in str(refused.value) and str(path) in str(refused.value)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(UserError, match=r"'dmo': unknown.*demo"):
        load_scenario("dmo")
