"""The proxy's core: how it changes datagrams, and both ends tolerate it."""

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.faults.faulty_link import LinkFault, Wire, faulty_link, forged
from stillarm.common.datagrams.datagram import DEMO_KEY, Datagram, Rejected, decode
from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.controller.input.exchange import ControllerExchange
from stillarm.supervisor.exchange import SupervisorExchange

_chance = st.floats(0.0, 1.0)
_faults = st.builds(
    LinkFault,
    drop=_chance,
    jitter_s=st.floats(0.0, 0.05),
    duplicate=_chance,
    reorder=_chance,
    corrupt=_chance,
    truncate=_chance,
    oversize=_chance,
    replay=st.integers(0, 3),
    forge=st.integers(0, 3),
)


def test_each_fault_does_what_it_says() -> None:
    rng, data, past = random.Random(1), bytes(range(100)), [b"past"]

    def through(**fault: float) -> list[tuple[float, bytes]]:
        return faulty_link(LinkFault(**fault), data, past, rng)  # type: ignore[arg-type]

    assert through() == [(0.0, data)]
    assert through(drop=1.0) == []
    assert through(delay_s=0.5) == [(0.5, data)]
    assert through(duplicate=1.0) == [(0.0, data)] * 2
    assert through(reorder=1.0) == [(0.02, data)]
    assert 0.0 <= through(jitter_s=0.01)[0][0] <= 0.01
    ((_, corrupt),) = through(corrupt=1.0)
    assert sum((a ^ b).bit_count() for a, b in zip(data, corrupt, strict=True)) == 1
    assert len(through(truncate=1.0)[0][1]) < 100 < len(through(oversize=1.0)[0][1])
    assert [d for _, d in through(replay=2)] == [data, b"past", b"past"]
    assert len(through(forge=4)) == 5


@given(st.integers(), st.binary(min_size=1, max_size=200))
def test_nothing_forged_is_taken(seed: int, data: bytes) -> None:
    assert isinstance(decode(DEMO_KEY, forged(data, random.Random(seed))), Rejected)


@settings(max_examples=60, deadline=None)
@given(_faults, st.integers(0, 2**32))
def test_over_any_link_samples_come_whole_in_order_and_once(fault: LinkFault, seed: int) -> None:
    """Whatever the network does: no sample that was not sent, none twice, none out of order."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 2)
    up, down = Wire(seed), Wire(seed + 1)
    up.fault = down.fault = fault
    got: list[VisualSample] = []
    for cycle in range(300):
        now = cycle * 0.001
        down.send(controller.timestamp(cycle, now), now)
        supervisor.take(down.arrived(now), now)
        if cycle % 15 == 0:
            supervisor.begin_cycles()
            sample = VisualSample(cycle, supervisor.oldest().cycle, 0, displacement_x_px=cycle * 0.5)
            up.send(supervisor.end_cycle(sample, now), now)
        got += controller.take(up.arrived(now), cycle, now)
    frames = [sample.frame for sample in got]
    assert frames == sorted(set(frames))
    assert all(sample.displacement_x_px == sample.frame * 0.5 for sample in got)
    if fault.drop == fault.corrupt == fault.truncate == fault.oversize == 0.0:
        assert frames


def test_a_wire_passes_everything_on_in_order() -> None:
    wire = Wire(0)
    for i in range(5):
        wire.send(bytes([i]), i * 0.001)
    assert wire.arrived(0.0025) == [b"\0", b"\1", b"\2"]
    assert wire.arrived(1.0) == [b"\3", b"\4"]
    assert not isinstance(decode(DEMO_KEY, b""), Datagram)
