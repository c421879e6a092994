"""A sequence of steps a cycle apart: order, what is due, what is done at once, and going back."""

from stillarm.controller.estimation.fused.frame_steps import NOTHING, SpreadWork, Steps

FIRST, PREPARE, USE, LAST = "first", "prepare", "use", "last"


def course(done: list[str], name: str = "") -> Steps:
    """Four steps; the second is done again as often as what it has prepared is withdrawn before it is used."""
    yield FIRST
    done.append(name + FIRST)
    while True:
        yield PREPARE
        done.append(name + PREPARE)
        if not (yield USE):
            break
    done.append(name + USE)
    yield LAST
    done.append(name + LAST)


def test_a_step_is_done_in_each_call_and_the_next_one_is_due() -> None:
    work, done, due = SpreadWork(), [], []
    work.begin(course(done))
    assert done == []
    while work.due != NOTHING:
        due.append(work.due)
        work.advance()
        assert done == due
    assert done == [FIRST, PREPARE, USE, LAST]


def test_without_a_sequence_nothing_is_due_and_nothing_happens() -> None:
    work = SpreadWork()
    for _ in range(2):
        work.advance()
        work.withdraw()
        work.advance_through(frozenset((FIRST, LAST)))
        assert work.due == NOTHING


def test_what_is_withdrawn_is_prepared_anew() -> None:
    work, done = SpreadWork(), []
    work.begin(course(done))
    work.advance()
    work.advance()
    work.withdraw()
    assert work.due == PREPARE and done == [FIRST, PREPARE]
    work.advance_through(frozenset((PREPARE, USE, LAST)))
    assert done == [FIRST, PREPARE, PREPARE, USE, LAST]


def test_steps_are_done_at_once_up_to_the_first_that_may_wait() -> None:
    work, done = SpreadWork(), []
    work.begin(course(done))
    work.advance_through(frozenset((FIRST, PREPARE, LAST)))
    assert work.due == USE and done == [FIRST, PREPARE]


def test_a_new_sequence_takes_the_place_of_what_is_left_of_the_old_one() -> None:
    work, done = SpreadWork(), []
    work.begin(course(done, "old "))
    work.advance()
    work.begin(course(done, "new "))
    assert work.due == FIRST
    work.advance()
    assert done == ["old first", "new first"]
