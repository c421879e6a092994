"""Every state with every event, against the rules that the table must obey, and the document that shows it."""

import pytest

from stillarm.controller.safety.table import (
    BIT_OF,
    GROUNDS,
    MOVING,
    TRANSITIONS,
    Event,
    Reaction,
    State,
)
from tests.fixtures.expected_states import EXPECTED, SEEN


@pytest.mark.parametrize("event", Event)
@pytest.mark.parametrize("state", State)
def test_each_event_in_each_state(state: State, event: Event) -> None:
    """An event that is not listed leaves the state unchanged."""
    assert TRANSITIONS[state, event] is EXPECTED.get((state, event), state)


def test_the_table_is_whole() -> None:
    """A state for every pair, nothing else; each event that is seen has its ground, with message and remedy."""
    assert set(TRANSITIONS) == {(state, event) for state in State for event in Event}
    assert len(set(SEEN)) == len(SEEN) == len(BIT_OF)
    assert all(ground.message and ground.remedy for ground in GROUNDS)


def test_nothing_leads_to_motion_but_the_operator_or_health() -> None:
    """Out of the resting states only `arm` leads to motion, and out of a fault only `clear` leads anywhere."""
    for (state, event), following in TRANSITIONS.items():
        if state not in MOVING and following in MOVING:
            assert (state, event) == (State.IDLE, Event.ARM)
        if state is State.FAULT and following is not state:
            assert event is Event.CLEAR


def test_no_reaction_takes_longer_than_a_fifth_of_a_second() -> None:
    """From when the loss counts; and where the loss is one of grounds, it counts within 0.1 s."""
    for ground in GROUNDS:
        assert ground.zero_within_s <= 0.1
        if ground.event in (Event.DRIVE_SILENT, Event.VISION_STALE, Event.NON_FINITE, Event.EMERGENCY_STOP):
            assert ground.seen_within_s + ground.zero_within_s <= 0.2
        assert (ground.zero_within_s == 0.0) == (ground.reaction is Reaction.HOLD)
