"""One quantity, each value against the last."""

from stillarm.controller.input.plausible_steps import PlausibleSteps


def accepted(values: list[float], slack: float = 1.0, per_s: float = 1.0) -> list[bool]:
    steps = PlausibleSteps(slack, per_s, 3)
    return [steps.accepts(value, 0.1 * place) for place, value in enumerate(values)]


def test_a_lone_jump_is_refused_and_the_level_before_goes_on() -> None:
    assert accepted([0.0, 0.5, 50.0, 0.6, -50.0, 40.0, 0.7]) == [True, True, False, True, False, False, True]


def test_a_jump_that_three_values_confirm_is_another_level() -> None:
    steps = PlausibleSteps(1.0, 1.0, 3)
    assert steps.accepts(0.0, 0.0)
    assert [steps.accepts(50.0, 0.1), steps.accepts(50.2, 0.2)] == [False, False]
    assert steps.accepts(50.1, 0.3) and steps.moved
    assert steps.accepts(50.3, 0.4) and not steps.moved


def test_the_room_that_time_gives_does_not_hide_a_jump() -> None:
    """1.25 lies within reach of the level before only because a value was refused meanwhile."""
    steps = PlausibleSteps(1.0, 1.0, 3)
    assert steps.accepts(0.0, 0.0)
    assert [steps.accepts(1.25, 0.1 * k) for k in (1, 4, 5)] == [False, False, True]
    assert steps.moved


def test_after_a_time_without_values_a_larger_step_is_plausible() -> None:
    steps = PlausibleSteps(1.0, 1.0, 3)
    assert steps.accepts(0.0, 0.0) and steps.accepts(4.9, 4.0)
