"""The cost of a cycle without an estimate: it sends the timestamp and receives visual datagrams."""

from time import perf_counter_ns

import numpy as np

from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, FRAME_S
from stillarm.common.datagrams.datagram import encode
from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample, visual_message
from stillarm.controller.input.exchange import ControllerExchange

_KEY, _SESSION, _PEER_SESSION = bytes(32), 1, 2


def empty_cycle_us(cycles: int = 10_000) -> dict[str, float]:
    """Mean and median time of a cycle that only exchanges the datagrams, us, with a sample in each frame period."""
    exchange = ControllerExchange(_KEY, _SESSION)
    every = round(FRAME_S / CYCLE_S)
    datagrams = {cycle: [_visual(cycle, cycle // every)] for cycle in range(every, cycles, every)}
    nothing: list[bytes] = []
    took = np.empty(cycles)
    taken = 0
    for cycle in range(cycles):
        waiting = datagrams.get(cycle, nothing)
        began = perf_counter_ns()
        exchange.timestamp(cycle)
        samples = exchange.take(waiting, cycle)
        took[cycle] = 1e-3 * (perf_counter_ns() - began)
        taken += len(samples)
    assert taken == len(datagrams), "the exchange refused its own datagrams"
    return {"mean": float(took.mean()), "median": float(np.median(took))}


def _visual(cycle: int, frame: int) -> bytes:
    started = max(0, cycle - 80)
    sample = VisualSample(
        frame, started, TrackingStatus.MEASURED, 0.5, 0.5, 0.0, 0.01, 0.01, 0.0, 1e-8, 0.5, 0.015, 100, 100
    )
    return encode(_KEY, _PEER_SESSION, frame, visual_message(_SESSION, sample), echo=_SESSION)
