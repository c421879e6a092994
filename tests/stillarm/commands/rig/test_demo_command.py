"""The demo's words about its result."""

from typing import Any

import pytest

from stillarm.commands.rig.demo_command import comparison_line, overload, print_table


def summary(frames: int, lost: int, cycles: int = 12000, missed: int = 0) -> dict[str, Any]:
    times = ("settling_time_free_s", "settling_time_damped_s", "settling_time_free_fitted_s")
    damping = dict.fromkeys((*times, "damping_ratio_free", "damping_ratio_damped"), 1.0)
    counts = {"cycles": cycles, "deadline_misses": missed, "frames": frames, "frames_lost": lost}
    return {**counts, "damping": damping, "methods": {}, "replay_identical": True}


@pytest.mark.parametrize(("frames", "lost", "told"), [(780, 0, False), (720, 60, False), (89, 615, True)])
def test_a_computer_that_could_not_keep_up_is_told_of(
    frames: int, lost: int, told: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run that lost most of its images says little about the method."""
    print_table(summary(frames, lost))
    assert ("too busy" in capsys.readouterr().out) == told


@pytest.mark.parametrize(("cycles", "missed", "told"), [(29610, 440, False), (19327, 10674, True)])
def test_a_loop_without_time_is_told_of(cycles: int, missed: int, told: bool) -> None:
    """Both were measured: the first predicted to 0.8 %, the second to 6.3 %, and damped nothing."""
    assert ("the loop's cycles" in overload(summary(1938, 9, cycles, missed))) == told


@pytest.mark.parametrize(
    ("errors", "says"),
    [
        (
            {"timestamps": 0.118, "correlation": 0.029, "fused": 0.009},
            "to 0.9 % on average, against timestamps 11.8 %, ",
        ),
        ({"timestamps": 0.118, "correlation": 0.009, "fused": 0.02}, "worse than correlation here"),
        ({"timestamps": None, "fused": 0.02}, ""),
        ({"timestamps": 0.1, "fused": None}, ""),
        ({}, ""),
    ],
)
def test_the_summary_says_what_fused_reached_against_the_others(
    errors: dict[str, float | None], says: str
) -> None:
    """It also says when fused is worse, and says nothing without a score."""
    line = comparison_line({name: {"prediction_error_mean": error} for name, error in errors.items()})
    assert says in line and "\n" not in line
    assert bool(line) == bool(says)
