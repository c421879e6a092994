"""What a page may do in each state: the machine's own table says it, and every refusal has its reason in words."""

from itertools import product

import pytest

from stillarm.controller.safety.machine import StateMachine
from stillarm.controller.safety.table import GROUNDS, MAY_ADJUST, MOVING, Event, Setting, State
from stillarm.panel.operate.actions import COMMANDS, MEANINGS, Action
from stillarm.panel.operate.permitted import (
    NO_CONTROLLER,
    READ_ONLY,
    Situation,
    refusal,
    setting_refusal,
    words_of,
)


def now(state: State, reason: str = "", **other: bool) -> Situation:
    return Situation(str(state), reason, silent=False, signed_in=True)._replace(**other)


@pytest.mark.parametrize("action", list(Action))
def test_a_page_without_the_token_may_do_nothing(action: Action) -> None:
    for state in State:
        assert refusal(action, now(state, signed_in=False)) == READ_ONLY


def test_a_stop_is_always_sent_and_nothing_else_without_a_controller() -> None:
    silent = now(State.ARMED, silent=True)
    assert refusal(Action.STOP, silent) == ""
    assert {refusal(action, silent) for action in Action if action is not Action.STOP} == {NO_CONTROLLER}


@pytest.mark.parametrize(("action", "state"), [*product(COMMANDS, State)])
def test_what_is_offered_changes_the_state_of_the_real_machine(action: Action, state: State) -> None:
    """And what is refused would not."""
    if action is Action.STOP:
        return
    bits, _ = COMMANDS[action]
    machine = StateMachine(0.001, arm_at_start=False)
    machine.state = state
    # in preflight the checks do not hold, else the machine would have left it by itself
    machine.step(1, 0, int(bits), ready=state is not State.PREFLIGHT, damping=state is State.DAMPING)
    changed = machine.state is not state and machine.state not in MOVING - {State.ARMED}
    offered = refusal(action, now(state)) == ""
    assert offered == changed, f"{action} in {state}: {refusal(action, now(state))!r}, then {machine.state}"


def test_a_refusal_before_arming_names_the_ground_and_its_remedy() -> None:
    why = refusal(Action.ARM, now(State.PREFLIGHT, "drive lost"))
    assert "the drive has not reported for a second" in why and "gateway" in why
    assert "joint" in refusal(Action.ARM, now(State.PREFLIGHT))


def test_damping_is_held_and_allowed_in_turn() -> None:
    free, held = now(State.DAMPING, damping_allowed=True), now(State.ARMED, held=True, damping_allowed=False)
    assert refusal(Action.HOLD_DAMPING, free) == "" and refusal(Action.ALLOW_DAMPING, free) != ""
    assert refusal(Action.HOLD_DAMPING, held) != "" and refusal(Action.ALLOW_DAMPING, held) == ""
    assert "configuration" in refusal(Action.ALLOW_DAMPING, now(State.ARMED, damping_allowed=False))


@pytest.mark.parametrize("state", list(State))
def test_a_setting_is_offered_where_the_controllers_table_has_it(state: State) -> None:
    for setting in Setting:
        assert (setting_refusal(setting, now(state)) == "") == ((setting, state) in MAY_ADJUST)
        assert setting_refusal(setting, now(state, signed_in=False)) == READ_ONLY
        assert setting_refusal(setting, now(state, silent=True)) == NO_CONTROLLER


def test_only_a_simulated_rig_is_struck() -> None:
    assert refusal(Action.STRIKE, now(State.ARMED, simulated=True)) == ""
    assert "simulated" in refusal(Action.STRIKE, now(State.ARMED))


def test_every_ground_has_words_and_whatever_moves_is_asked_for() -> None:
    for ground in GROUNDS:
        assert words_of(str(ground.event)) == {"message": ground.message, "remedy": ground.remedy}
    assert words_of("") == {"message": "", "remedy": ""}
    assert words_of(str(Event.DISARM))["message"] == "disarm"
    assert set(MEANINGS) == set(Action)
    moving = {Action.ARM, Action.ALLOW_DAMPING, Action.STRIKE, Action.CLEAR}
    assert {action for action, meaning in MEANINGS.items() if meaning.asks} == moving
