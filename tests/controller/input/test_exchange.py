"""Both ends of the exchange (Fig. 2), joined without a network."""

from math import nan

from hypothesis import given
from hypothesis import strategies as st

from stillarm.common.datagrams.datagram import DEMO_KEY, encode
from stillarm.common.datagrams.messages import Reference
from stillarm.common.datagrams.visual_sample import VisualSample, visual_message
from stillarm.common.files.model import Model
from stillarm.common.link.operator_sender import OperatorSender
from stillarm.controller.input.exchange import (
    ControllerExchange,
    ReferenceExchange,
    oldest_sample_s,
    visual_sample,
)
from stillarm.supervisor.exchange import SupervisorExchange
from tests.fixtures.link_ends import sample
from tests.reference.plain_datagram import FIELDS, plain_datagram


@given(
    st.builds(
        VisualSample,
        st.integers(-1, 2**63),
        st.integers(-1, 2**63),
        st.integers(0, 9),
        *[st.floats(allow_nan=False)] * 9,
        *[st.integers(0, 1000)] * 2,
    )
)
def test_a_visual_sample_comes_back_from_its_message(sample: VisualSample) -> None:
    assert visual_sample(visual_message(7, sample)) == sample


def test_the_timestamp_comes_back_with_the_data() -> None:
    """n_i is the latest timestamp when the supervisor's cycle began, not when it ended."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    controller.expect(22)
    supervisor.take([controller.timestamp(c) for c in (5, 6, 7)])
    supervisor.begin_cycles()
    supervisor.take([controller.timestamp(c) for c in (8, 9)])
    data = supervisor.end_cycle(sample(supervisor.oldest().cycle))
    (got,) = controller.take([data], 30)
    assert got.started_cycle == 7
    assert got.displacement_x_px == 1.5
    supervisor.begin_cycles()
    assert supervisor.oldest().cycle == 9


def test_what_answers_another_session_or_the_future_is_not_taken() -> None:
    """A restarted controller must not date frames by the timestamps of its former life."""
    old, new = ControllerExchange(DEMO_KEY, 11), ControllerExchange(DEMO_KEY, 12)
    supervisor = SupervisorExchange(DEMO_KEY, 22, 2)
    old.expect(22)
    supervisor.take([old.timestamp(900)])
    supervisor.begin_cycles()
    data = supervisor.end_cycle(sample(900))
    assert new.take([data], 5) == []
    assert new.counts.unproven == 1
    assert old.take([data], 899) == []
    supervisor.take([new.timestamp(2)])
    assert new.take([supervisor.end_cycle(sample(900))], 5) == []  # of the old one's timestamp
    assert new.counts.old_session == 1
    supervisor.take([new.timestamp(3)])
    supervisor.begin_cycles()
    assert len(new.take([supervisor.end_cycle(sample(3))], 5)) == 1


def test_a_reference_lapses() -> None:
    """Held for a tenth of a second, then zero."""
    reference = ReferenceExchange(DEMO_KEY, 11)
    assert reference.reference(0.0) == (0.0, True)
    reference.take([encode(DEMO_KEY, 5, 1, Reference(0.2, False), echo=11)], 1.0)
    assert reference.reference(1.05) == (0.2, False)
    assert reference.reference(1.2) == (0.0, True)
    reference.take([encode(DEMO_KEY, 5, 2, Reference(nan, True), echo=11)], 1.3)
    assert reference.reference(1.3) == (0.0, True)


@given(st.lists(st.binary(max_size=200), max_size=5))
def test_any_bytes_are_survived(datagrams: list[bytes]) -> None:
    """At all three ends."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    assert controller.take(datagrams, 5) == []
    supervisor.take(datagrams)
    assert supervisor.latest.cycle == -1
    ReferenceExchange(DEMO_KEY, 11).take(datagrams, 0.0)


@given(
    st.lists(
        st.one_of(st.integers(), st.floats(), st.text(max_size=5), st.none(), st.booleans()), max_size=16
    )
)
def test_any_signed_body_is_survived(body: list[object]) -> None:
    """Signed nonsense of the right or the wrong length."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    try:
        forms = [
            plain_datagram(DEMO_KEY, kind, 7, 1, body, echo=echo) for kind in FIELDS for echo in (11, 22)
        ]
    except (OverflowError, ValueError):
        return
    controller.take(forms, 5)
    supervisor.take(forms)
    ReferenceExchange(DEMO_KEY, 11).take(forms, 0.0)


def test_the_ends_find_each_other_from_nothing_and_after_a_restart() -> None:
    """No samples are lost but those that began before the supervisor knew the controller."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    taken = []
    for cycle in range(8):
        if cycle == 4:
            supervisor = SupervisorExchange(DEMO_KEY, 23, 1)
        supervisor.take([controller.timestamp(cycle)])
        supervisor.begin_cycles()
        taken += controller.take([supervisor.end_cycle(sample(supervisor.oldest().cycle))], cycle)
    assert [s.started_cycle for s in taken] == [1, 2, 3, 5, 6, 7]


def test_a_recording_of_the_link_moves_nothing() -> None:
    """Everything that was exchanged in an earlier run, played to both ends of this one, before and during it."""
    record: list[bytes] = []

    def run(sessions: tuple[int, int], played: list[bytes]) -> int:
        controller, supervisor = (
            ControllerExchange(DEMO_KEY, sessions[0]),
            SupervisorExchange(DEMO_KEY, sessions[1], 1),
        )
        count = 0
        for cycle in range(30):
            assert controller.take(played, cycle) == []
            before = supervisor.latest
            supervisor.take(played)
            assert supervisor.latest == before
            record.append(controller.timestamp(cycle))
            supervisor.take(record[-1:])
            supervisor.begin_cycles()
            record.append(supervisor.end_cycle(sample(supervisor.oldest().cycle)))
            count += len(controller.take(record[-1:], cycle))
        return count

    assert run((11, 22), []) == 29
    assert run((12, 23), list(record)) == 29


def test_an_operator_is_taken_after_it_was_answered() -> None:
    """A recorded reference moves nothing in another run."""
    operator, reference = OperatorSender(DEMO_KEY, 5), ReferenceExchange(DEMO_KEY, 11)
    first = operator.reference(0.2, True)
    reference.take([first], 1.0)
    assert reference.reference(1.0) == (0.0, True) and not operator.known
    operator.take([reference.hello() or b""])
    second = operator.reference(0.2, False)
    reference.take([second], 1.1)
    assert operator.known and reference.hello() is None
    assert reference.reference(1.1) == (0.2, False)
    later = ReferenceExchange(DEMO_KEY, 12)
    later.take([first, second], 9.0)
    assert later.reference(9.0) == (0.0, True)


def test_what_was_held_up_on_its_way_is_no_ground_to_damp_on() -> None:
    """A sample older than images asked for ahead, delay and a tenth of a second is counted, not taken."""
    oldest_s = oldest_sample_s(Model(), 4)
    assert 0.2 < oldest_s < 0.3
    controller, supervisor = ControllerExchange(DEMO_KEY, 11, 250), SupervisorExchange(DEMO_KEY, 22, 2)
    controller.expect(22)
    supervisor.take([controller.timestamp(100)])
    supervisor.begin_cycles()
    first, second = (supervisor.end_cycle(sample(100, frame)) for frame in (1, 2))
    assert len(controller.take([first], 350)) == 1
    assert controller.take([second], 351) == []
    assert controller.counts.overdue == 1
