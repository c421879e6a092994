"""Jobs in processes of their own: progress, last lines, a bad end, two at most, and none left behind."""

import asyncio
import os

import pytest

from stillarm.common.user_error import UserError
from stillarm.panel.recordings.jobs import Jobs

pytestmark = pytest.mark.slow


def test_a_job_tells_its_end_and_its_last_line() -> None:
    async def run() -> None:
        jobs = Jobs()
        assert jobs.get("x") is None
        job = await jobs.start("x", "causes", "no such cause")
        assert job.told()["running"] and not await job.ended()
        told = job.told()
        assert not told["running"] and not told["good"] and "no such cause" in told["lines"][-1]
        job = await jobs.start("x", "causes", "cubic_stiffness")
        assert await job.ended() and job.told()["good"]

    asyncio.run(run())


def test_a_job_gives_way_unless_it_moves_the_arm() -> None:
    async def niceness(moves: bool) -> int:
        job = await Jobs().start("x", "-n1", "import time; time.sleep(9.0)", module="timeit", moves=moves)
        try:
            return os.getpriority(os.PRIO_PROCESS, job._process.pid) - os.getpriority(os.PRIO_PROCESS, 0)
        finally:
            await job.stop()

    assert [asyncio.run(niceness(moves)) for moves in (True, False)] == [0, 10]


def test_progress_lines_are_taken_and_others_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    async def run() -> None:
        job = await Jobs().start("x", "-h", module="timeit")
        for line in ("progress 0.42 fused", "progress of none", "progress 7 over", "said"):
            job._take(line)
        told = job.told()
        assert (told["done"], told["label"]) == (1.0, "over")
        assert [line for line in told["lines"] if line in {"progress of none", "said"}] == [
            "progress of none",
            "said",
        ]
        await job.ended()

    asyncio.run(run())


def test_a_third_job_is_refused_and_all_are_stopped() -> None:
    async def run() -> None:
        jobs = Jobs()
        running = [await jobs.start(name, "0", module="http.server") for name in ("a", "b")]
        with pytest.raises(UserError, match="a and b are running"):
            await jobs.start("c", "causes")
        with pytest.raises(UserError, match="a is running already"):
            await jobs.start("a", "causes")
        await jobs.stop_all()
        assert not any(job.running for job in running)
        with pytest.raises(ProcessLookupError):
            os.kill(running[0]._process.pid, 0)

    asyncio.run(run())
