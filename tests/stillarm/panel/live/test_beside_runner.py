"""The process of the methods beside: there while a page wants one, and never waited for."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from stillarm.panel.live.beside import FIRST_KIND
from stillarm.panel.live.beside_runner import BesideRunner
from stillarm.panel.server.subscribers import Subscribers
from tests.fixtures.imports import ROOT

CONFIGURATION = ROOT / "configs" / "simulated_rig.toml"
WITHIN_S = 30.0  # a process starts, on a computer that may be busy

pytestmark = pytest.mark.slow


def telemetry(begin: int) -> bytes:
    """A datagram of 30 cycles of a still arm."""
    rows = [{"time_s": 0.001 * cycle, "fast": {"cycle": cycle}} for cycle in range(begin, begin + 30)]
    return msgspec.msgpack.encode(rows)


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(WITHIN_S):
        while not condition():
            await asyncio.sleep(0.02)


def test_it_runs_while_a_page_wants_a_method() -> None:
    async def check() -> None:
        pages = Subscribers()
        runner, page = BesideRunner(CONFIGURATION, pages), pages.add()
        assert page is not None
        await runner.look()
        runner.take(telemetry(0))  # nobody wants anything
        assert runner._process is None
        page.beside = frozenset({"timestamps"})
        await runner.look()
        process = runner._process
        assert process is not None
        runner.take(telemetry(30))
        async with asyncio.timeout(WITHIN_S):
            message = await page.get()
        assert isinstance(message, bytes) and message[0] == FIRST_KIND
        pages.remove(page)  # the page was closed
        await runner.look()
        assert process.returncode == 0 and runner._process is None

    asyncio.run(check())


def test_a_process_that_falls_behind_is_not_waited_for_and_one_that_ended_is_no_error(tmp_path: Path) -> None:
    """The first reads nothing while it starts: what is beyond the bound is left out. The second has no file."""

    async def check() -> None:
        pages = Subscribers()
        page = pages.add()
        assert page is not None
        page.beside = frozenset({"timestamps"})
        runner = BesideRunner(CONFIGURATION, pages)
        await runner.look()
        for _ in range(50):
            runner.take(bytes(60_000))
        assert runner._process is not None and runner._process.stdin is not None
        assert runner._process.stdin.transport.get_write_buffer_size() < 1_200_000
        await runner.close()
        lost = BesideRunner(tmp_path / "nowhere.toml", pages)
        await lost.look()
        assert lost._process is not None
        async with asyncio.timeout(WITHIN_S):
            assert await lost._process.wait() == 1
        lost.take(telemetry(0))
        await lost.look()
        await lost.close()

    asyncio.run(check())
