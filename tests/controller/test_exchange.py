"""Both ends of the exchange (Fig. 2), joined without a network."""

from math import nan

from hypothesis import given
from hypothesis import strategies as st

from common.datagram import DEMO_KEY, Kind, encode
from common.visual_sample import VisualSample
from controller.exchange import ControllerExchange, ReferenceExchange
from supervisor.exchange import SupervisorExchange


def sample(started: int, frame: int = 1) -> VisualSample:
    return VisualSample(frame, started, 0, displacement_x_px=1.5, captured_s=nan)


def test_the_timestamp_comes_back_with_the_data() -> None:
    """n_i is the latest timestamp when the supervisor's cycle began, not when it ended."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    supervisor.take([controller.timestamp(c) for c in (5, 6, 7)])
    supervisor.begin_cycles()
    supervisor.take([controller.timestamp(c) for c in (8, 9)])
    data = supervisor.end_cycle(sample(supervisor.oldest().cycle))
    (got,) = controller.take([data], 30)
    assert got.started_cycle == 7
    assert got.displacement_x_px == 1.5
    supervisor.begin_cycles()
    assert supervisor.oldest().cycle == 9


def test_cycles_in_flight_come_back_in_order() -> None:
    """Four images asked for ahead: each comes with the timestamp of its own request."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 4)
    started = []
    for cycle in range(0, 150, 15):
        supervisor.take([controller.timestamp(cycle)])
        supervisor.begin_cycles()
        started.append(supervisor.oldest().cycle)
        supervisor.end_cycle(sample(supervisor.oldest().cycle))
    assert started == [0, 0, 0, 0, 15, 30, 45, 60, 75, 90]


def test_what_answers_another_session_or_the_future_is_not_taken() -> None:
    """A restarted controller must not date frames by the timestamps of its former life."""
    old, new = ControllerExchange(DEMO_KEY, 11), ControllerExchange(DEMO_KEY, 12)
    supervisor = SupervisorExchange(DEMO_KEY, 22, 1)
    supervisor.take([old.timestamp(900)])
    supervisor.begin_cycles()
    data = supervisor.end_cycle(sample(900))
    assert new.take([data], 5) == []
    assert new.counts.old_session == 1
    assert old.take([data], 899) == []
    supervisor.take([new.timestamp(3)])
    supervisor.begin_cycles()
    assert len(new.take([supervisor.end_cycle(sample(3))], 5)) == 1


def test_a_reference_lapses() -> None:
    """Held for a tenth of a second, then zero."""
    reference = ReferenceExchange(DEMO_KEY)
    assert reference.reference(0.0) == (0.0, True)
    reference.take([encode(DEMO_KEY, Kind.REFERENCE, 5, 1, (0.2, False))], 1.0)
    assert reference.reference(1.05) == (0.2, False)
    assert reference.reference(1.2) == (0.0, True)
    reference.take([encode(DEMO_KEY, Kind.REFERENCE, 5, 2, (nan, True))], 1.3)
    assert reference.reference(1.3) == (0.0, True)


@given(st.lists(st.binary(max_size=200), max_size=5))
def test_any_bytes_are_survived(datagrams: list[bytes]) -> None:
    """By all three ends."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    assert controller.take(datagrams, 5) == []
    supervisor.take(datagrams)
    assert supervisor.latest.cycle == -1
    ReferenceExchange(DEMO_KEY).take(datagrams, 0.0)


@given(
    st.lists(
        st.one_of(st.integers(), st.floats(), st.text(max_size=5), st.none(), st.booleans()), max_size=16
    )
)
def test_any_signed_body_is_survived(body: list[object]) -> None:
    """Signed nonsense of the right or the wrong length."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 1)
    try:
        forms = [encode(DEMO_KEY, kind, 7, 1, tuple(body)) for kind in Kind]
    except (OverflowError, ValueError):
        return
    controller.take(forms, 5)
    supervisor.take(forms)
    ReferenceExchange(DEMO_KEY).take(forms, 0.0)
