"""Commands that take long, each in a process of its own: its lines, its progress, its end. Edge: processes."""

import asyncio
import contextlib
import signal
from collections import deque
from typing import Any

from stillarm.common.process.child_process import module_command
from stillarm.common.process.parent_death import beginning
from stillarm.common.user_error import UserError

_LINES = 40
_LONGEST_LINE = 4000
_MOST_JOBS = 2  # at the same time: the rig's computer has other things to do
_ENDS_WITHIN_S = 10.0
_NICENESS = 10


class Job:
    """One process. Its progress comes from lines `progress 0.42 LABEL` on its standard error."""

    def __init__(self, name: str, process: asyncio.subprocess.Process) -> None:
        """Use Jobs.start()."""
        self.name = name
        self._process = process
        self._lines: deque[str] = deque(maxlen=_LINES)
        self._done = 0.0
        self._label = ""
        self._reading = asyncio.gather(self._read(process.stdout), self._read(process.stderr), process.wait())

    async def _read(self, stream: asyncio.StreamReader | None) -> None:
        assert stream is not None
        while True:
            try:
                line = await stream.readline()
            except ValueError:  # longer than the reader's limit: the rest comes with the next line
                continue
            if not line:
                return
            self._take(line.decode(errors="replace").rstrip()[:_LONGEST_LINE])

    def _take(self, line: str) -> None:
        word, _, rest = line.partition(" ")
        number, _, label = rest.partition(" ")
        if word == "progress":
            with contextlib.suppress(ValueError):
                self._done, self._label = min(1.0, max(0.0, float(number))), label
                return
        if line:
            self._lines.append(line)

    @property
    def running(self) -> bool:
        """Whether the process has not ended."""
        return self._process.returncode is None

    def told(self) -> dict[str, Any]:
        """For the page: name, whether it runs, whether it ended well, progress 0 to 1 with its label, last lines."""
        return {
            "name": self.name,
            "running": self.running,
            "good": self._process.returncode == 0,
            "done": self._done,
            "label": self._label,
            "lines": list(self._lines),
        }

    async def ended(self) -> bool:
        """Wait for the end; whether it was a good one."""
        await self._reading
        return self._process.returncode == 0

    async def stop(self) -> None:
        """Ask it to end, and kill it when it does not."""
        if not self.running:
            return
        self._process.send_signal(signal.SIGINT)
        try:
            async with asyncio.timeout(_ENDS_WITHIN_S):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()


class Jobs:
    """The jobs by name; a name's next job takes the last one's place once that has ended."""

    def __init__(self) -> None:
        """None yet."""
        self._jobs: dict[str, Job] = {}

    def get(self, name: str) -> Job | None:
        """The newest job of that name."""
        return self._jobs.get(name)

    async def start(self, name: str, *arguments: str, module: str = "stillarm", moves: bool = False) -> Job:
        """Run `python -m MODULE ARGUMENTS`. moves: it moves the arm, and gives way to nothing on this computer.

        Raises UserError where it runs already, or too many others do.
        """
        running = [job.name for job in self._jobs.values() if job.running]
        if name in running:
            raise UserError(f"{name} is running already; wait for its end")
        if len(running) >= _MOST_JOBS:
            raise UserError(f"{' and '.join(running)} are running; wait for one of them")
        command, environment = module_command(module, *arguments)
        process = await asyncio.create_subprocess_exec(
            *command,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env=environment | {"STILLARM_PROGRESS": "lines"},
            preexec_fn=beginning(0 if moves else _NICENESS),
        )
        self._jobs[name] = Job(name, process)
        return self._jobs[name]

    async def stop_all(self) -> None:
        """Stop whatever runs."""
        for job in self._jobs.values():
            await job.stop()
