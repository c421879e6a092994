"""Counts of a window."""

import secrets

import pytest

from stillarm.benchmarks.loop.run import Window
from stillarm.controller.safety.table import State
from stillarm.controller.statistics.loop_block import LoopBlock


def test_a_window_counts_from_when_it_was_opened() -> None:
    """What came before, start-up among it, is left out: the greatest, too."""
    block = LoopBlock(f"test-window-{secrets.token_hex(4)}", create=True)
    try:
        block.end_cycle(0, 0.5, 0.4, 0, State.ARMED, None)
        block.note_overrun(0, 500, (0.001, 0.5, 0.0, 0.0), (0, 0, 0, 0, 0))
        window = Window(block)
        for cycle in range(501, 601):
            block.end_cycle(cycle, 30e-6, 100e-6, 0, State.ARMED, None)
        block.note_overrun(600, 2, (0.001, 0.0, 0.0, 0.0), (0, 0, 0, 0, 0))
        result = window.result()
        assert (result["cycles"], result["deadline_misses"]) == (100, 2)
        assert result["wakeup_latency_us"]["max"] == pytest.approx(30.0)
        assert window.compute_us()["p99"] == pytest.approx(100.0, abs=1.0)
    finally:
        block.close()
