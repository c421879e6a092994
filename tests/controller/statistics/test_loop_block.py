"""The loop's block from both sides, and the statistics that are read from it."""

import secrets
from collections.abc import Iterator

import pytest

from stillarm.controller.input.plausible_input import Field
from stillarm.controller.safety.table import Event, State
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.controller.statistics.overrun import OverrunCause
from stillarm.controller.statistics.statistics_process import Statistics


@pytest.fixture
def sides() -> Iterator[tuple[LoopBlock, LoopBlock]]:
    """Writer and reader."""
    name = f"test-loop-{secrets.token_hex(4)}"
    writer = LoopBlock(name, create=True)
    reader = LoopBlock(name, create=False)
    yield writer, reader
    reader.close()
    writer.close()
    writer.close()


def run(writer: LoopBlock, first: int, cycles: int, compute_s: float = 1e-4) -> None:
    for cycle in range(first, first + cycles):
        writer.end_cycle(cycle, 3e-5, compute_s, int(cycle % 15 == 0), State.DAMPING, None)


def test_a_line_tells_of_the_last_second_alone(sides: tuple[LoopBlock, LoopBlock]) -> None:
    """Counts and percentiles are those since the line before."""
    writer, reader = sides
    statistics = Statistics(reader)
    run(writer, 0, 1000)
    first = statistics.line()
    assert (first["cycles"], first["missed"], first["visual_samples"]) == (1000, 0, 67)
    assert first["compute_us"]["p50"] == pytest.approx(100.0, abs=1.0)  # type: ignore[index]
    assert (first["state"], first["reason"]) == ("damping", "")
    run(writer, 1000, 500, 4e-4)
    second = statistics.line()
    assert second["cycles"] == 500
    assert second["compute_us"]["p50"] == pytest.approx(400.0, abs=1.0)  # type: ignore[index]
    assert second["cycle"] == 1499


def test_overruns_come_with_their_cause_once(sides: tuple[LoopBlock, LoopBlock]) -> None:
    """The worst one's cause and counters; more than the ring holds are counted all the same."""
    writer, reader = sides
    statistics = Statistics(reader)
    assert statistics.overruns(False, 0.0) is None
    writer.note_overrun(17, 3, (0.001, 0.0035, 1e-4, 1e-4), (0, 0, 5, 0, 0))
    writer.note_overrun(40, 1, (0.001, 1e-5, 0.0021, 1e-4), (0, 0, 5, 0, 0))
    told = statistics.overruns(False, 0.0)
    assert told is not None
    assert told["causes"] == {OverrunCause.NO_CPU: 1, OverrunCause.SLOW_BUS: 1}
    assert (told["worst_cycle"], told["worst_missed"], told["cause"]) == (17, 3, "no CPU")
    assert statistics.overruns(False, 0.0) is None
    for cycle in range(200):
        writer.note_overrun(cycle, 1, (0.001, 1e-5, 1e-4, 0.0015), (0, 0, 0, 0, 0))
    told = statistics.overruns(True, 0.0)
    assert told is not None and told["cause"] == "throttling"
    assert told["overruns"] == 200 and told["missed"] == 200
    assert reader.misses == 204


def test_changes_of_state_are_kept_in_order(sides: tuple[LoopBlock, LoopBlock]) -> None:
    """Only changes; a reader that comes late gets those that are still held."""
    writer, reader = sides
    for cycle, (state, reason) in enumerate(
        [
            (State.ARMED, None),
            (State.ARMED, None),
            (State.DEGRADED, Event.VISION_STALE),
            (State.FAULT, Event.GROWING),
        ]
    ):
        writer.end_cycle(cycle, 0.0, 0.0, 0, state, reason)
    count, changes = reader.changes(0)
    assert count == 3
    assert [(c.cycle, c.state, c.reason) for c in changes] == [
        (0, State.ARMED, None), (2, State.DEGRADED, Event.VISION_STALE), (3, State.FAULT, Event.GROWING),
    ]  # fmt: skip
    assert reader.changes(count) == (3, [])
    assert not reader.ended
    writer.end()
    assert reader.ended


def test_refused_values_are_told_once_by_field(sides: tuple[LoopBlock, LoopBlock]) -> None:
    """Counts since the last call; nothing where there are none."""
    writer, reader = sides
    statistics = Statistics(reader)
    assert statistics.refused() is None
    counts = [0] * len(Field)
    counts[Field.ACCELERATION], counts[Field.CAPTURED] = 3, 1
    writer.note_refused(counts)
    told = statistics.refused()
    assert told is not None and told["values"] == {"acceleration": 3, "captured": 1}
    counts[Field.CAPTURED] = 5
    writer.note_refused(counts)
    assert (statistics.refused() or {})["values"] == {"captured": 4}
    assert statistics.refused() is None
