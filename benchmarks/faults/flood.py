"""`benchmark flood`: the controller under a flood of forged datagrams, between two quiet stretches of the same run."""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from stillarm.benchmarks.faults.flood_sender import RATE_HZ, sent_by, start_flood
from stillarm.benchmarks.faults.live_rig import LiveRig
from stillarm.benchmarks.loop.counters import block_name
from stillarm.benchmarks.loop.run import Window
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.statistics.loop_block import LoopBlock

_SETTLE_S = 2.0
_REFUSED = ("forged", "malformed", "foreign_version", "unexpected", "unproven", "duplicate", "shed")


def run(
    duration_s: float, seed: int, progress: Callable[[float], None] = lambda done: None
) -> dict[str, Any]:
    """Run `duration_s` / 2 quietly, `duration_s` flooded, `duration_s` / 2 quietly. Raises UserError on failure."""
    with tempfile.TemporaryDirectory(prefix="stillarm-flood-") as folder:
        rig = LiveRig(Path(folder), seed)
        try:
            rows, sent = _measure(rig, duration_s, seed, progress)
            rig.stop("controller")
            recording = open_recording(rig.recording)
            for row in rows:
                row["damping_share"] = damping_share(recording, row.pop("from_s"), row.pop("to_s"))
            refused = refused_counts(recording)
        finally:
            rig.close()
    return {
        "rate_hz": sent / duration_s,
        "sent": sent,
        "rows": rows,
        "refused": refused,
        "asked": verdict(rows),
    }


def _measure(
    rig: LiveRig, duration_s: float, seed: int, progress: Callable[[float], None]
) -> tuple[list[dict[str, Any]], int]:
    name = block_name(rig.process_id("controller"))
    if name is None:
        raise UserError("benchmark flood: the controller has no counters; is another version running?")
    block = LoopBlock(name, create=False)
    try:
        rig.proxy.pump(_SETTLE_S)
        before = _window("quiet before", rig, block, duration_s / 2.0)
        progress(0.25)
        flooding = start_flood(rig.proxy.up.past, rig.controller_port, RATE_HZ, duration_s, seed)
        during = _window("flood", rig, block, duration_s)
        sent = sent_by(flooding)
        progress(0.75)
        after = _window("quiet after", rig, block, duration_s / 2.0)
        progress(1.0)
    finally:
        block.close()
    return [before, during, after], sent


def _window(name: str, rig: LiveRig, block: LoopBlock, duration_s: float) -> dict[str, Any]:
    window, from_s = Window(block), time.monotonic()
    rig.proxy.pump(duration_s)
    to_s, found = time.monotonic(), window.result()
    return {
        "stretch": name,
        "cycles": found["cycles"],
        "missed": found["deadline_misses"],
        "wakeup_p99_us": found["wakeup_latency_us"]["p99"],
        "compute_p99_us": window.compute_us()["p99"],
        "from_s": from_s,
        "to_s": to_s,
    }


def damping_share(recording: Recording, from_s: float, to_s: float) -> float:
    """Fraction of the recorded cycles in a span of monotonic time in which the damping acted; 0 without cycles."""
    estimates, origin_s = recording.columns("/estimate"), recording.header.origin_monotonic_s
    times = np.asarray(estimates["time_s"]) + origin_s
    status = np.asarray(estimates["damping_status"])[(times >= from_s) & (times < to_s)]
    return float(np.mean(status == "active")) if len(status) else 0.0


def refused_counts(recording: Recording) -> dict[str, int]:
    """Number of refused datagrams in the whole run by reason, without the last second."""
    link = recording.columns("/link")
    return {name: int(link[name][-1]) for name in _REFUSED if len(link[name])}


def verdict(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Required: at most twice the misses of an equally long quiet time, and damping as in the quiet time."""
    before, during, after = rows
    asked = (
        ("missed in the flood", during["missed"], 2 * (before["missed"] + after["missed"]), True),
        (
            "share damped in the flood",
            during["damping_share"],
            0.9 * min(before["damping_share"], after["damping_share"]),
            False,
        ),
    )
    return [
        {
            "asked": name,
            "found": found,
            "bound": bound,
            "kept": "yes" if (found <= bound if most else found >= bound) else "no",
        }
        for name, found, bound, most in asked
    ]
