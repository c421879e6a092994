"""This machine's loop, the bare timer thread, and cyclictest if installed, in turns of a second each; then sections.

All of them run in one thread (cyclictest in its own process) on one processor at one priority, so that they measure
the same machine.
"""

import os
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from stillarm.benchmarks.loop import cyclictest
from stillarm.benchmarks.loop.cycle_budget import CycleBudget
from stillarm.benchmarks.loop.own_work import OwnWork
from stillarm.benchmarks.loop.slices import Measured, by_name, run_slice
from stillarm.common.files.configuration import (
    default_configuration_path,
    load_assumed_model,
    load_configuration,
)
from stillarm.common.process.loop_processor import loop_processor
from stillarm.controller.loop.realtime import FIFO, RealTime
from stillarm.controller.loop.warm_up import warm_up

_SLICE_S = 1.0
_WARM_CYCLES = 500
_OF_SECTIONS = 0.2  # of the duration, each for the cycle's sections and for their floor


def run(duration_s: float, progress: Callable[[float], None] = lambda done: None) -> dict[str, Any]:
    """Measure for about `duration_s` in total. Returns the content of the benchmark's file.

    "missing": the controller's privileges that this process lacks. "sections": each section of a cycle, by name.
    """
    path = default_configuration_path()
    configuration = load_configuration(path)
    model = load_assumed_model(configuration, path)
    cycle_s = model.timing.cycle_s
    warm_up(model, configuration.controller, str(path))
    work = OwnWork(model, configuration.controller)
    loop, floor, peer = Measured(), Measured(), Measured()
    with_peer = cyclictest.installed()
    in_turns_s = duration_s * (1.0 - 2.0 * _OF_SECTIONS)
    turns = max(1, round(in_turns_s / (_SLICE_S * (3 if with_peer else 2))))
    length_s = min(_SLICE_S, in_turns_s / 2.0)
    before = os.sched_getaffinity(0), os.sched_getscheduler(0), os.sched_getparam(0)
    budget = CycleBudget()
    realtime = RealTime()
    missing = realtime.enter()
    try:
        for _ in range(_WARM_CYCLES):
            work()
        processor = loop_processor()
        for turn in range(turns):
            run_slice(loop, length_s, cycle_s, work)
            run_slice(floor, length_s, cycle_s)
            if with_peer:
                cyclictest.run_slice(peer, length_s, cycle_s, processor, FIFO not in missing)
            progress((1.0 - 2.0 * _OF_SECTIONS) * (turn + 1) / turns)
        sections = budget.measure(_OF_SECTIONS * duration_s)
        progress(1.0)
    finally:
        realtime.leave()
        os.sched_setscheduler(0, before[1], before[2])
        os.sched_setaffinity(0, before[0])
        work.close()
        budget.close()
    result: dict[str, Any] = {
        "loop": loop.result(),
        "floor": floor.result(),
        "compute_us": by_name(loop.compute.summary()),
        "missing": [str(each) for each in missing],
        "sections": {section.name.lower(): asdict(figures) for section, figures in sections.items()},
    }
    return result | ({"cyclictest": peer.result()} if peer.cycles else {})
