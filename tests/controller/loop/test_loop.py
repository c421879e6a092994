"""The loop on a clock and devices of the test's own: its order, its end, and that nothing of a cycle stays behind."""

import gc
import itertools
import secrets
import statistics
import sys
import tracemalloc
from array import array
from collections.abc import Iterator
from math import cos, pi

import msgspec
import numpy as np
import pytest

from stillarm.common.datagrams.datagram import DEMO_KEY, encode
from stillarm.common.datagrams.visual_sample import VisualSample, visual_message
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import Regression
from stillarm.common.files.model import Arm, Model
from stillarm.common.memory.shared_memory import SharedRing
from stillarm.common.recording.topics import TOPICS
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.input.exchange import ControllerExchange
from stillarm.controller.loop.loop import Loop, said_of
from stillarm.controller.loop.step import Controller
from stillarm.controller.safety.table import Event, State
from stillarm.controller.statistics.loop_block import LoopBlock

FRAMES = 30  # of a call from the loop to whatever asks for memory
MODEL = Model(arm=Arm(length_m=2.0))
W = 2.0 * pi * 2.6


class Clock:
    """Never sleeps; skips the cycles that it is told to."""

    def __init__(self, skipped: dict[int, int] | None = None) -> None:
        self.origin_s, self.misses = 0.0, 0
        self.skipped = skipped or {}

    def start(self) -> int:
        return 0

    def wait(self, last: int) -> int:
        missed = self.skipped.get(last, 0)
        self.misses += missed
        return last + 1 + missed


NOISE = [float(value) for value in np.random.default_rng(0).normal(0.0, 0.5, 4099)]  # m/s^2


class Devices:
    """A vibration seen by a noisy accelerometer and by images; what was done is kept in order."""

    accelerometer_faults = 0
    damping = True
    link_counts: dict[str, int]

    def __init__(self) -> None:
        self.done: list[tuple[str, float]] | None = []
        names = (
            "accepted lost duplicate late malformed forged foreign_version old_session unexpected sessions"
        )
        self.link_counts = dict.fromkeys(names.split(), 0)

    def link_status(self) -> dict[str, float]:
        return {}

    def read(self, cycle: int) -> CycleInput:
        if self.done is not None:
            self.done.append(("read", cycle))
        samples = []
        if cycle % 15 == 0:
            seen = -800.0 * 0.006 * cos(W * (cycle - 74) * 0.001)
            samples.append(VisualSample(cycle // 15, max(0, cycle - 60), 0, seen, 0.0, 0.0, 0.0025, 0.0025))
        acceleration = -W * W * 0.006 * cos(W * cycle * 0.001) + NOISE[cycle % len(NOISE)]
        return CycleInput(cycle, acceleration, 0.0, 0.0, 0.001, 0.02, self.damping, samples)

    def write(self, command_rad_s: float) -> None:
        if self.done is not None:
            self.done.append(("write", command_rad_s))


class RingRecorder:
    """The recorder's ring without its process: emptied by the test."""

    def __init__(self) -> None:
        self.ring = SharedRing(f"test-ring-{secrets.token_hex(4)}", 1 << 20, create=True)
        self.encode = msgspec.msgpack.Encoder().encode
        self.prefix = [bytes((index,)) for index in range(len(TOPICS))]
        self.lost = 0

    def put(self, topic_index: int, message: msgspec.Struct) -> None:
        self.ring.put(self.prefix[topic_index] + self.encode(message))

    def alive(self) -> bool:
        return True


@pytest.fixture
def parts() -> Iterator[tuple[Devices, RingRecorder, LoopBlock]]:
    devices, recorder = Devices(), RingRecorder()
    block = LoopBlock(f"test-loop-{secrets.token_hex(4)}", create=True)
    yield devices, recorder, block
    block.close()
    recorder.ring.close()


def loop_of(
    parts: tuple[Devices, RingRecorder, LoopBlock],
    clock: Clock | None = None,
    settings: Settings | None = None,
) -> Loop:
    devices, recorder, block = parts
    controller = Controller(MODEL, settings or Settings(arm_at_start=True))
    return Loop(controller, devices, recorder, block, clock or Clock(), 0.001)  # type: ignore[arg-type]


def test_read_then_write_in_every_cycle_and_the_command_fades_at_the_end(
    parts: tuple[Devices, RingRecorder, LoopBlock],
) -> None:
    """Asked to stop at cycle 1000: the last command is zero, within 0.15 s, and no step on the way is a jump."""
    loop_of(parts).run(lambda cycle: cycle >= 1000)
    done = parts[0].done
    assert done is not None
    assert [what for what, _ in done[:6]] == ["read", "write"] * 3
    commands = [value for what, value in done if what == "write"]
    assert abs(commands[999]) > 0.005
    assert commands[-1] == 0.0
    assert 1000 < len(commands) <= 1150
    assert max(abs(b - a) for a, b in itertools.pairwise(commands[999:])) < 0.0021
    assert parts[2].ended and parts[2].cycles == len(commands)


def test_missed_cycles_are_counted_with_their_counters(
    parts: tuple[Devices, RingRecorder, LoopBlock],
) -> None:
    """The cycle number advances by the number of missed cycles."""
    loop = loop_of(parts, Clock({100: 3, 200: 1}))
    loop.run(lambda cycle: cycle >= 300)
    count, overruns = parts[2].overruns(0)
    assert count == 2
    assert [(overrun.cycle, overrun.missed) for overrun in overruns] == [(100, 3), (200, 1)]
    assert parts[2].misses == 4
    assert "4 deadlines missed" in loop.summary()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "settled"),
    [("correlation", 6000), ("timestamps", 6000), ("kalman_fusion", 6000), ("fused", 45_030)],
)
def test_no_allocation_survives_a_cycle(
    parts: tuple[Devices, RingRecorder, LoopBlock], method: str, settled: int
) -> None:
    """Blocks of memory held, looked at once a second: the median of the last eight looks exceeds that of the eight
    before them by less than a block for every two seconds between them; and no circle of references is left, which only
    the collector, which is off, could free.

    A single look differs from the next by up to ten blocks in either direction, whatever a number's size and the last
    image happened to be: two looks beside each other cannot tell a leak.

    settled: when the method's own memory, of a fixed length, is full; a regression's window is made one of that.
    """
    devices, recorder, _ = parts
    settings = Settings(arm_at_start=True, method=method, regression=Regression(variable_window=False))
    devices.done = None
    blocks = array("q", [0] * 16)
    looks = range(settled, settled + 16 * 1005, 1005)  # all right after an image

    def watch(cycle: int) -> bool:
        while recorder.ring.get() is not None:
            pass
        if cycle in looks:
            blocks[looks.index(cycle)] = sys.getallocatedblocks()
        return cycle > looks[-1]

    gc.collect()
    gc.disable()
    try:
        loop_of(parts, settings=settings).run(watch)
        unreachable = gc.collect()
    finally:
        gc.enable()
    assert unreachable == 0
    assert statistics.median(blocks[8:]) - statistics.median(blocks[:8]) < 4


def bytes_of_the_loop() -> int:
    """What is traced and was asked for by the loop, or by what it calls: pytest's own threads ask for memory, too."""
    filters = (
        tracemalloc.Filter(True, "*/stillarm/controller/loop/*", all_frames=True),
        tracemalloc.Filter(False, tracemalloc.__file__, all_frames=True),  # the snapshot before
    )
    return sum(trace.size for trace in tracemalloc.take_snapshot().filter_traces(filters).traces)


@pytest.mark.slow
def test_no_traced_byte_survives_a_thousand_cycles(parts: tuple[Devices, RingRecorder, LoopBlock]) -> None:
    """The same by tracemalloc, which sees the arrays as well: less than a float for each cycle, by far. With a method
    whose memory is full soon.
    """
    devices, recorder, _ = parts
    devices.done = None
    traced = array("q", [0, 0])

    def watch(cycle: int) -> bool:
        while recorder.ring.get() is not None:
            pass
        if cycle == 6000:
            tracemalloc.start(FRAMES)
        if cycle in (7500, 8505):
            traced[cycle == 8505] = bytes_of_the_loop()
        return cycle > 8505

    gc.disable()
    try:
        loop_of(parts, settings=Settings(arm_at_start=True, method="correlation")).run(watch)
    finally:
        tracemalloc.stop()
        gc.enable()
    assert traced[0] > 0
    assert traced[1] - traced[0] < 1000


def test_the_exchange_keeps_nothing_of_a_datagram() -> None:
    """A thousand cycles of timestamps out and images in."""
    session, other = (1 << 62) + 1, (1 << 62) + 3
    exchange = ControllerExchange(DEMO_KEY, session, 500)

    def exchange_for(cycles: range) -> None:
        for cycle in cycles:
            exchange.timestamp(cycle, cycle * 0.001)
            if cycle % 15 == 0:
                sample = VisualSample(cycle, cycle, 0, 0.5, 0.0, 0.0, 0.1, 0.1, 0.0, 0.1, 0.5, 0.01, 9, 9)
                data = encode(DEMO_KEY, other, cycle + 1, visual_message(session, sample), echo=session)
                exchange.take([data], cycle, cycle * 0.001)

    exchange_for(range(30_000))
    before = sys.getallocatedblocks()
    exchange_for(range(30_000, 31_000))
    assert sys.getallocatedblocks() - before <= 2  # numbers that have become too large to be kept ready


def test_each_state_has_its_words() -> None:
    """A remedy where something is missing; made once, so that the loop formats nothing."""
    level, text = said_of(State.DEGRADED, Event.VISION_STALE)
    assert level == "warning" and "supervisor" in text
    level, text = said_of(State.FAULT, Event.GROWING)
    assert level == "error" and "operate clear" in text
    assert said_of(State.ARMED, None) == ("info", "armed")
    assert said_of(State.FAULT, Event.GROWING)[1] is text
