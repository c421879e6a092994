"""Starts the process of beside_process.py while a page wants methods, and hands its messages on. Edge: the process.

It runs at a lower priority, and never holds the panel up: what it has no time for is left out.
"""

import asyncio
import contextlib
from pathlib import Path
from typing import Any

import msgspec

from stillarm.common.process.child_process import module_command
from stillarm.common.process.parent_death import beginning
from stillarm.panel.live.beside_process import HEAD, LENGTH, TELEMETRY, WANTED
from stillarm.panel.server.subscribers import Subscribers

_MOST_BEHIND_BYTES = 1 << 20  # some two seconds of telemetry
_NICENESS = 10  # as the jobs': the rig's computer has other things to do
_ENDS_WITHIN_S = 2.0


class BesideRunner:
    """One process for all pages; none while no page wants a method."""

    def __init__(self, configuration: Path, pages: Subscribers) -> None:
        """configuration: the controller's file. pages: say what they want, and get the messages."""
        self._configuration, self._pages = configuration, pages
        self._wanted: frozenset[str] = frozenset()
        self._process: asyncio.subprocess.Process | None = None
        self._reading: asyncio.Task[None] | None = None

    async def look(self) -> None:
        """Follow what the pages want now. Call it some times a second, never twice at once."""
        wanted = self._pages.beside()
        if wanted == self._wanted:
            return
        self._wanted = wanted
        if not wanted:
            return await self.close()
        if self._process is None or self._process.returncode is not None:
            await self._start()
        self._write(WANTED, msgspec.json.encode(sorted(wanted)))

    def take(self, datagram: bytes) -> None:
        """A datagram of telemetry. Never waits."""
        self._write(TELEMETRY, datagram)

    def _write(self, kind: int, content: bytes) -> None:
        stream = self._process.stdin if self._process is not None else None
        if stream is None or stream.is_closing():
            return
        if kind == WANTED or stream.transport.get_write_buffer_size() < _MOST_BEHIND_BYTES:
            stream.write(HEAD.pack(kind, len(content)) + content)

    async def _start(self) -> None:
        command, environment = module_command("stillarm.panel.live.beside_process", str(self._configuration))
        pipes: dict[str, Any] = {"stdin": asyncio.subprocess.PIPE, "stdout": asyncio.subprocess.PIPE}
        self._process = await asyncio.create_subprocess_exec(
            *command, **pipes, env=environment, preexec_fn=beginning(_NICENESS)
        )
        assert self._process.stdout is not None
        self._reading = asyncio.create_task(self._hand_on(self._process.stdout))

    async def _hand_on(self, stream: asyncio.StreamReader) -> None:
        with contextlib.suppress(asyncio.IncompleteReadError):  # it has ended
            while True:
                (length,) = LENGTH.unpack(await stream.readexactly(LENGTH.size))
                self._pages.put(await stream.readexactly(length))

    async def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is None:
            return
        if process.stdin is not None:
            process.stdin.close()
        try:
            async with asyncio.timeout(_ENDS_WITHIN_S):
                await process.wait()
        except TimeoutError:
            process.kill()
            await process.wait()
        if self._reading is not None:
            self._reading.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._reading
