"""`benchmark panel`: what open pages cost the loop and the server, and how old a sample is at a page's socket.

In turns: no panel at all, a panel with no page, with one, with twenty. A page is a WebSocket that reads everything;
what a browser itself costs its computer is no part of it.
"""

import asyncio
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from aiohttp import ClientSession, ClientWebSocketResponse, WSMsgType

from stillarm.benchmarks.loop.counters import block_name
from stillarm.benchmarks.loop.run import Window
from stillarm.common.process.child_process import next_line, start_module, stop_process
from stillarm.common.user_error import UserError
from stillarm.controller.statistics.loop_block import LoopBlock
from stillarm.simulation.demo.attended import Attended, attended_demo

PAGES = (None, 0, 1, 20)
"""Open pages of each turn; None: no panel runs."""
_ROUNDS = 3
_READY_WITHIN_S = 60.0
_SETTLE_S = 2.0
_TICKS_S = os.sysconf("SC_CLK_TCK")
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


def run(
    duration_s: float, seed: int, progress: Callable[[float], None] = lambda done: None
) -> dict[str, Any]:
    """Run the demo and the turns; rows by number of pages. Raises UserError if a process fails."""
    turns = [(pages, number) for number in range(_ROUNDS) for pages in PAGES]
    seen: dict[int | None, list[dict[str, Any]]] = {pages: [] for pages in PAGES}
    with tempfile.TemporaryDirectory(prefix="stillarm-panel-pages-") as folder:
        directory = Path(folder) / "demo"
        with attended_demo(directory, seed, lambda label: nullcontext(lambda done: None)) as demo:
            block = _block(demo)
            try:
                for done, (pages, _) in enumerate(turns):
                    seen[pages].append(_turn(demo, directory, block, pages, duration_s / len(turns)))
                    demo.check()
                    progress((done + 1) / len(turns))
            finally:
                block.close()
    return {"rows": [summed(pages, parts) for pages, parts in seen.items()]}


def _block(demo: Attended) -> LoopBlock:
    """The controller's counters, once its loop runs and has settled."""
    deadline = time.monotonic() + _READY_WITHIN_S
    while (name := block_name(demo.process_ids["controller"])) is None:
        demo.check()
        if time.monotonic() > deadline:
            raise UserError(
                "benchmark panel: the controller did not start in time; is the machine overloaded?"
            )
        time.sleep(0.05)
    block = LoopBlock(name, create=False)
    while block.cycles == 0 and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(_SETTLE_S)
    return block


def _turn(
    demo: Attended, directory: Path, block: LoopBlock, pages: int | None, seconds: float
) -> dict[str, Any]:
    if pages is None:
        window = Window(block)
        time.sleep(seconds)
        return window.result()
    words = ("--config", str(demo.configuration), "--recordings", str(directory), "--port", "0")
    panel = start_module("stillarm", "panel", *words, stdout=subprocess.PIPE)
    try:
        line = next_line(panel, _READY_WITHIN_S)
        if not line:
            raise UserError("benchmark panel: the panel did not start; its message above tells why")
        address = line.split()[-1].partition("#")[0]
        time.sleep(_SETTLE_S)
        window, used_s, begin_s = Window(block), _processor_s(panel.pid), time.monotonic()
        ages_s = asyncio.run(_read(address, pages, seconds))
        share = (_processor_s(panel.pid) - used_s) / (time.monotonic() - begin_s)
        return window.result() | {"share": share, "mib": _resident_mib(panel.pid), "ages_s": ages_s}
    finally:
        stop_process(panel, 5.0)


async def _read(address: str, pages: int, seconds: float) -> list[float]:
    """Open the pages and read them for a while; each sample's age as the first page reads it, s."""
    ages_s: list[float] = []
    async with ClientSession() as session:
        origin = address.rstrip("/")
        sockets = [
            await session.ws_connect(f"{address}api/live", headers={"Origin": origin}) for _ in range(pages)
        ]
        readers = [
            asyncio.create_task(_page(socket, ages_s if number == 0 else []))
            for number, socket in enumerate(sockets)
        ]
        await asyncio.sleep(seconds)
        for reader in readers:
            reader.cancel()
    return ages_s


async def _page(socket: ClientWebSocketResponse, ages_s: list[float]) -> None:
    origin_s = float("nan")
    async for message in socket:
        now_s = time.monotonic()
        if message.type is WSMsgType.TEXT:
            told = msgspec.json.decode(message.data)
            if told["type"] == "status" and told["origin_exact"]:
                origin_s = told["origin_s"]
        elif message.data[0] == 0 and isfinite(origin_s):
            rows = int.from_bytes(message.data[2:4], "little")
            times_s = np.frombuffer(message.data, "<f8", rows, 8)
            ages_s.extend((now_s - origin_s - times_s).tolist())


def _processor_s(process: int) -> float:
    """Processor time that a process has used, s (proc(5), utime and stime)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_S


def _resident_mib(process: int) -> float:
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * _PAGE_BYTES / 2**20


def summed(pages: int | None, parts: list[dict[str, Any]]) -> dict[str, Any]:
    """One row from the turns with that number of pages: medians of the latencies, sums of counts."""
    late = [part["wakeup_latency_us"] for part in parts]
    ages_ms = 1e3 * np.array([age for part in parts for age in part.get("ages_s", [])])
    shares = [part["share"] for part in parts if "share" in part]
    return {
        "pages": "no panel" if pages is None else str(pages),
        "wakeup_p50_us": float(np.median([one["p50"] for one in late])),
        "wakeup_p999_us": float(np.median([one["p999"] for one in late])),
        "deadline_misses": sum(part["deadline_misses"] for part in parts),
        "cycles": sum(part["cycles"] for part in parts),
        "server_core_percent": 100.0 * max(shares) if shares else None,
        "server_mib": max(part["mib"] for part in parts) if shares else None,
        "age_p50_ms": float(np.percentile(ages_ms, 50)) if ages_ms.size else None,
        "age_p99_ms": float(np.percentile(ages_ms, 99)) if ages_ms.size else None,
    }
