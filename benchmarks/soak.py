"""Runs the demo's processes for a long time: does memory grow, do descriptors leak, does the cycle drift?"""

import contextlib
import select
import socket
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import tomli_w

from stillarm.simulation.demo.demo import remove_shared_memory, wait_for_camera
from stillarm.simulation.demo.processes import DemoProcesses
from stillarm.simulation.demo.set_up import write_demo_configuration

_START_SHARE = 0.2  # of the time; caches fill and pools grow in it
_SAMPLE_EVERY_S = 1.0
_MOST_GROWTH_MB_PER_H = 4.0
_MOST_GROWTH_MB = 1.0  # the allocator's step size: below it a slope means nothing
_MOST_DRIFT_S = 0.001


class ProcessSamples:
    """Private memory (without shared rings) and descriptors of one process over time."""

    def __init__(self) -> None:
        """Start without samples."""
        self.times_s: list[float] = []
        self.memory_mb: list[float] = []
        self.descriptors: list[int] = []

    def take(self, process: int, time_s: float) -> None:
        """Sample a process. A process that has ended gives no sample."""
        with contextlib.suppress(OSError, ValueError, IndexError):
            status = Path(f"/proc/{process}/status").read_text()
            kilobytes = int(status.split("RssAnon:")[1].split()[0])
            count = len(list(Path(f"/proc/{process}/fd").iterdir()))
            self.times_s.append(time_s)
            self.memory_mb.append(kilobytes * 1024 / 1e6)
            self.descriptors.append(count)

    def result(self, from_s: float) -> dict[str, Any]:
        """The growth from a time on."""
        times = np.array(self.times_s)
        late = times >= from_s
        if np.count_nonzero(late) < 3:
            return {"ended": True}
        memory, hours = np.array(self.memory_mb)[late], times[late] / 3600.0
        descriptors = np.array(self.descriptors)[late]
        third = max(1, len(memory) // 3)
        return {
            "memory_mb": float(memory[-1]),
            "memory_growth_mb": float(np.median(memory[-third:]) - np.median(memory[:third])),
            "memory_slope_mb_per_h": float(np.polyfit(hours, memory, 1)[0]),
            "descriptors": int(descriptors[-1]),
            "descriptor_growth": int(np.median(descriptors[-third:]) - np.median(descriptors[:third])),
        }


def run(
    duration_s: float, seed: int, progress: Callable[[float], None] = lambda done: None
) -> dict[str, Any]:
    """Run the demo's three processes for `duration_s`. Returns growth by process, drift, and problems."""
    with (
        tempfile.TemporaryDirectory(prefix="stillarm-soak-") as folder,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as telemetry,
    ):
        telemetry.bind(("127.0.0.1", 0))
        path, configuration, _ = write_demo_configuration(
            Path(folder), max(12.0, min(duration_s, 600.0)), seed
        )
        port = telemetry.getsockname()[1]
        changed = msgspec.structs.replace(
            configuration, telemetry=msgspec.structs.replace(configuration.telemetry, port=port)
        )
        path.write_text(tomli_w.dumps(msgspec.to_builtins(changed)))
        processes = DemoProcesses(Path(folder))
        try:
            processes.start("rig", "--config", str(path))
            wait_for_camera(configuration.camera.device, processes)
            processes.start("supervisor", "--config", str(path))
            recording = str(Path(folder) / "recording.mcap")
            processes.start(
                "controller", "--config", str(path), "--record", recording, "--allow-non-realtime"
            )
            samples, lags = _watch(processes, telemetry, duration_s, progress)
        finally:
            processes.stop_all()
            remove_shared_memory(configuration)
    return _judge(samples, lags, duration_s)


def _watch(
    processes: DemoProcesses, telemetry: socket.socket, duration_s: float, progress: Callable[[float], None]
) -> tuple[dict[str, ProcessSamples], list[tuple[float, float]]]:
    samples: dict[str, ProcessSamples] = {}
    lags: list[tuple[float, float]] = []  # time, and the lag of the cycle's own time behind it, s
    began = time.monotonic()
    next_s = began
    least = float("inf")
    while (now := time.monotonic()) < began + duration_s:
        if select.select([telemetry], [], [], max(0.0, next_s - now))[0]:
            arrived = time.monotonic()
            rows = msgspec.msgpack.decode(telemetry.recv(65536))
            newest = max((row["time_s"] for row in rows if "fast" in row), default=None)
            if newest is not None:
                least = min(least, arrived - newest)
            continue
        processes.check()
        for name, process in _family(processes):
            samples.setdefault(name, ProcessSamples()).take(process, now - began)
        if least < float("inf"):
            lags.append((now - began, least))
        least, next_s = float("inf"), now + _SAMPLE_EVERY_S
        progress((now - began) / duration_s)
    return samples, lags


def _family(processes: DemoProcesses) -> list[tuple[str, int]]:
    """The processes and their children, by name."""
    family = []
    for name, parent in processes.process_ids().items():
        family.append((name, parent))
        with contextlib.suppress(OSError):
            children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
            family += [(f"{name}, child {number}", int(child)) for number, child in enumerate(children, 1)]
    return family


def _judge(
    samples: dict[str, ProcessSamples], lags: list[tuple[float, float]], duration_s: float
) -> dict[str, Any]:
    from_s = _START_SHARE * duration_s
    results = {name: taken.result(from_s) for name, taken in samples.items()}
    late = [lag for time_s, lag in lags if time_s >= from_s]
    third = max(1, len(late) // 3)
    drift = min(late[-third:]) - min(late[:third]) if late else float("nan")
    problems = []
    for name, result in results.items():
        if result.get("ended"):
            problems.append(f"{name} ended")
            continue
        growth, slope = result["memory_growth_mb"], result["memory_slope_mb_per_h"]
        if growth > _MOST_GROWTH_MB and slope > _MOST_GROWTH_MB_PER_H:
            problems.append(f"{name} grows by {slope:.1f} MB/h")
        if result["descriptor_growth"] > 0:
            problems.append(f"{name} keeps {result['descriptor_growth']} more descriptors")
    if not abs(drift) < _MOST_DRIFT_S:
        problems.append(f"the cycle drifts by {1e3 * drift:.2f} ms against the clock")
    return {
        "duration_s": duration_s,
        "processes": results,
        "drift_s": drift if np.isfinite(drift) else None,
        "problems": problems,
    }
