"""The machine obeys its table."""

import pytest

from stillarm.controller.safety.machine import StateMachine
from stillarm.controller.safety.table import (
    BIT_OF,
    GROUNDS,
    MOVING,
    Event,
    Operator,
    Reaction,
    State,
)
from tests.fixtures.expected_states import EXPECTED, SEEN


def moved_to(state: State) -> StateMachine:
    """A machine that got there by the proper way."""
    machine = StateMachine(0.001, arm_at_start=False)
    ways = {
        State.PREFLIGHT: [],
        State.IDLE: [(0, 0, True, False)],
        State.ARMED: [(0, Operator.ARM, True, False)],
        State.DAMPING: [(0, Operator.ARM, True, False), (0, 0, False, True)],
        State.DEGRADED: [(0, Operator.ARM, True, False), (BIT_OF[Event.VISION_STALE], 0, False, False)],
        State.FAULT: [(0, Operator.EMERGENCY_STOP, False, False)],
    }
    for missing, operator, ready, damping in ways[state]:
        machine.step(1, missing, operator, ready=ready, damping=damping)
    assert machine.state is state
    return machine


@pytest.mark.parametrize("event", SEEN)
@pytest.mark.parametrize("state", State)
def test_the_machine_obeys_the_table(state: State, event: Event) -> None:
    """A ground that goes missing in each state: the table's next state, and permission by state and ground."""
    machine = moved_to(state)
    machine.step(1, BIT_OF[event], 0, ready=False, damping=state is State.DAMPING)
    following = EXPECTED.get((state, event), state)
    assert machine.state is following
    ground = next(ground for ground in GROUNDS if ground.event is event)
    assert machine.may_move == (following in MOVING and not ground.whole)
    assert machine.may_damp == (machine.may_move and ground.reaction is Reaction.HOLD)
    if ground.whole and ground.reaction is Reaction.ZERO:
        assert machine.at_once
    if following is not state:
        assert machine.reason is event


def test_a_fault_is_left_by_clear_and_arm_alone_even_when_armed_at_the_start() -> None:
    """In that order; and not while the switch is held."""
    machine = StateMachine(0.001, arm_at_start=True)
    machine.step(1, 0, 0, ready=True, damping=False)
    assert machine.state is State.ARMED and machine.may_move
    machine.step(1, 0, Operator.EMERGENCY_STOP, ready=False, damping=False)
    for word in (0, Operator.ARM, Operator.DISARM, Operator.CLEAR | Operator.EMERGENCY_STOP):
        machine.step(1, 0, word, ready=True, damping=False)
        assert machine.state is State.FAULT and not machine.may_move
    machine.step(1, 0, Operator.CLEAR, ready=True, damping=False)
    assert machine.state is State.IDLE
    machine.step(300, 0, 0, ready=True, damping=False)
    assert machine.state is State.IDLE
    machine.step(1, 0, Operator.ARM, ready=True, damping=False)
    assert machine.state is State.ARMED and machine.may_damp


def test_disarm_wins_over_arm_and_lasts() -> None:
    """Both at once, and with arm_at_start."""
    machine = StateMachine(0.001, arm_at_start=True)
    machine.step(1, 0, 0, ready=True, damping=False)
    machine.step(1, 0, Operator.DISARM | Operator.ARM, ready=True, damping=False)
    assert (machine.state, machine.reason) == (State.IDLE, Event.DISARM)
    machine.step(1, 0, 0, ready=True, damping=False)
    assert machine.state is State.IDLE and not machine.may_move and not machine.at_once


def test_a_drive_that_comes_back_is_armed_by_itself_only_where_that_is_configured() -> None:
    """Otherwise the operator is asked again."""
    for arm_at_start, wanted in ((True, State.ARMED), (False, State.IDLE)):
        machine = StateMachine(0.001, arm_at_start=arm_at_start)
        machine.step(1, 0, Operator.ARM, ready=True, damping=False)
        lost = BIT_OF[Event.DRIVE_LOST] | BIT_OF[Event.DRIVE_SILENT]
        machine.step(1, lost, 0, ready=False, damping=True)
        assert machine.state is State.PREFLIGHT and machine.at_once
        machine.step(1, lost, 0, ready=True, damping=False)
        assert machine.state is State.PREFLIGHT
        machine.step(1, 0, 0, ready=True, damping=False)
        assert machine.state is wanted


def test_what_came_back_counts_as_healthy_after_a_fifth_of_a_second() -> None:
    """Skipped cycles count with their time; damping is allowed as soon as nothing is missing."""
    machine = moved_to(State.DEGRADED)
    machine.step(1, 0, 0, ready=False, damping=False)
    assert machine.state is State.DEGRADED and machine.may_damp
    machine.step(198, 0, 0, ready=False, damping=True)
    assert machine.state is State.DEGRADED
    machine.step(1, 0, 0, ready=False, damping=True)
    assert machine.state is State.DAMPING and machine.reason is None
