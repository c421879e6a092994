"""The message about the link: one part of it a cycle, one message a second."""

import os
import secrets
from collections.abc import Iterator
from types import SimpleNamespace

import msgspec
import pytest

from stillarm.common.datagrams.datagram import LinkCounts
from stillarm.common.recording.topics import LinkSample
from stillarm.controller.loop.link_report import LinkReport
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.statistics.overrun import ThreadCounters


class Recorder:
    """Keeps what it is given, and notes in which cycle it was asked for what."""

    lost = 0

    def __init__(self) -> None:
        self.cycle = 0
        self.asked: list[tuple[int, str]] = []
        self.messages: list[LinkSample] = []

    def note(self, what: str) -> None:
        self.asked.append((self.cycle, what))

    def alive(self) -> bool:
        self.note("alive")
        return True

    def put(self, topic_index: int, message: LinkSample) -> None:
        self.note("put")
        self.messages.append(message)


class Devices:
    """Counters that note when they are read."""

    accelerometer_faults = 3

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder

    @property
    def link_counts(self) -> dict[str, int]:
        self._recorder.note("counts")
        return {name: int(value) for name, value in msgspec.structs.asdict(LinkCounts()).items()}

    def link_status(self) -> dict[str, float]:
        self._recorder.note("status")
        return {"shed": 5}


@pytest.fixture
def parts() -> Iterator[tuple[Recorder, LinkReport]]:
    recorder, counters = Recorder(), ThreadCounters()
    block = LoopBlock(f"link-test-{os.getpid()}-{secrets.token_hex(4)}", create=True)
    clock = SimpleNamespace(misses=2)
    yield recorder, LinkReport(Devices(recorder), block, clock, counters, 0.001, lambda: 0)  # type: ignore[arg-type]
    counters.close()
    block.close()


def test_each_cycle_does_one_part_and_each_second_gives_one_message(
    parts: tuple[Recorder, LinkReport],
) -> None:
    """The cycles bear their own numbers, so that a recording stays in order."""
    recorder, report = parts
    for cycle in range(2500):
        recorder.cycle = cycle
        report.advance(cycle, recorder)  # type: ignore[arg-type]
    cycles = [cycle for cycle, _ in recorder.asked]
    assert len(cycles) == len(set(cycles))
    assert [what for _, what in recorder.asked] == ["counts", "status", "alive", "put"] * 3
    assert [(m.cycle, m.deadline_misses, m.accelerometer_faults, m.shed) for m in recorder.messages] == [
        (begun + 4, 2, 3, 5) for begun in (0, 1000, 2000)
    ]


def test_a_report_under_way_is_completed_at_the_end(parts: tuple[Recorder, LinkReport]) -> None:
    """And where none is, nothing is said."""
    recorder, report = parts
    for cycle in range(2):
        report.advance(cycle, recorder)  # type: ignore[arg-type]
    report.finish(recorder)  # type: ignore[arg-type]
    report.finish(recorder)  # type: ignore[arg-type]
    assert [m.cycle for m in recorder.messages] == [1]
