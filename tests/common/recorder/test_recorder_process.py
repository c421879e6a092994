"""The recorder outlives the process that puts messages, and always completes the file."""

import contextlib
import errno
import io
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from mcap.reader import make_reader

from stillarm.common.memory.shared_memory import SharedRing, block_path
from stillarm.common.recorder.recorder_process import Drain, RecorderClient
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.reader import open_recording
from stillarm.common.recording.recover import recover
from stillarm.common.recording.topics import TOPIC_INDEX, FastSample, LogLine
from stillarm.common.recording.writer import RecordingWriter
from stillarm.common.user_error import UserError

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
FAST, LOG = TOPIC_INDEX["/fast"], TOPIC_INDEX["/log"]
HEADER = RecordingHeader(
    program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
)
LIMIT_S = 120.0  # for what takes a fraction of a second: a virtual machine may stand still for a minute


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline, "did not happen in time"
        time.sleep(0.01)


def cycles(path: Path) -> list[int]:
    with path.open("rb") as file:
        public = sum(1 for _ in make_reader(file).iter_messages())
    recording = open_recording(path)
    assert not recording.cut and public == sum(recording.counts.values())
    return [message.cycle for message in recording.messages("/fast")]


def test_close_completes_the_file(tmp_path: Path) -> None:
    client = RecorderClient.start(tmp_path / "a.mcap", HEADER)
    for i in range(2000):
        client.put(FAST, FastSample(i * 0.001, i))
    client.put(LOG, LogLine(2.0, "info", "end"))
    assert client.alive()
    assert client.close() and client.close()
    assert not client.alive() and client.lost == 0
    assert cycles(tmp_path / "a.mcap") == list(range(2000))
    assert next(open_recording(tmp_path / "a.mcap").messages("/log")).text == "end"


DAEMON = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell that runs tests behind it (`&`) has it ignored
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recorder.recorder_process import RecorderClient
from stillarm.common.recording.topics import FastSample
header = RecordingHeader(
    program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
)
client = RecorderClient.start(sys.argv[1], header)
for i in range(3000):
    client.put(0, FastSample(i * 0.001, i))
    if i % 100 == 0:
        time.sleep(0.001)
print(client._ring.block.path, client._process.pid, flush=True)
time.sleep(600)
"""


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_daemon_loses_nothing(tmp_path: Path, how: signal.Signals) -> None:
    """SIGINT goes to the daemon's whole process group, as Ctrl-C does."""
    path = tmp_path / "killed.mcap"
    daemon = subprocess.Popen(
        [sys.executable, "-c", DAEMON, str(path)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    assert daemon.stdout is not None
    with daemon.stdout:
        ring, recorder = daemon.stdout.readline().split()
    os.killpg(daemon.pid, how)
    daemon.wait(LIMIT_S)
    until(lambda: not Path(ring).exists())
    until(lambda: not is_running(int(recorder)))
    assert cycles(path) == list(range(3000))


def is_running(process: int) -> bool:
    """Whether it runs; one that ended and waits for whoever adopted it to notice does not."""
    with contextlib.suppress(OSError):
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        return state not in "ZX"
    return False


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_the_recorder_finishes_when_it_is_asked_to(tmp_path: Path, how: signal.Signals) -> None:
    client = RecorderClient.start(tmp_path / "a.mcap", HEADER)
    for i in range(500):
        client.put(FAST, FastSample(i * 0.001, i))
    os.kill(client._process.pid, how)
    until(lambda: not client.alive())
    client.put(FAST, FastSample(1.0, 1000))  # the daemon goes on
    assert client.close()
    assert cycles(tmp_path / "a.mcap") == list(range(500))


def test_a_killed_recorder_is_noticed_and_leaves_what_it_wrote(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    client = RecorderClient.start(path, HEADER, ring_bytes=8192)
    for i in range(10):
        client.put(FAST, FastSample(i * 0.001, i))
    until(lambda: open_recording(path).counts.get("/fast") == 10)  # it flushes by the clock
    os.kill(client._process.pid, signal.SIGKILL)
    until(lambda: not client.alive())
    for i in range(100):
        client.put(FAST, FastSample(i * 0.001, i))  # never blocks, though nobody reads
    assert client.lost > 50
    assert not client.close()
    assert not client._ring.block.path.exists()
    recording = open_recording(path)
    assert recording.cut and recording.counts["/fast"] == 10


def test_a_recorder_that_cannot_start_is_an_error_in_one_line(tmp_path: Path) -> None:
    before = set(block_path("x").parent.glob("stillarm-recorder-*"))
    with pytest.raises(UserError, match="cannot be written") as refused:
        RecorderClient.start(tmp_path / "none" / "a.mcap", HEADER)
    assert "\n" not in str(refused.value)
    mine = f"stillarm-recorder-{os.getpid()}-"
    after = set(block_path("x").parent.glob("stillarm-recorder-*"))
    assert not [p for p in after - before if p.name.startswith(mine)]


def _put_once_there_is_room(client: RecorderClient, sample: FastSample) -> None:
    """Repeat what finds the ring full: the recorder continues to empty it."""

    def accepted() -> bool:
        lost = client.lost
        client.put(FAST, sample)
        return client.lost == lost or not client.alive()

    until(accepted)


def test_a_full_disk_is_said_once_and_costs_the_daemon_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "full.mcap"
    client = RecorderClient.start(path, HEADER, ring_bytes=1 << 16)
    resource.prlimit(client._process.pid, resource.RLIMIT_FSIZE, (8000, 8000))
    for i in range(3000):
        _put_once_there_is_room(client, FastSample(i * 0.001, i, float(hash((i, 1)) % 10**9)))
    assert client.alive()
    assert not client.close()
    said = [line for line in capfd.readouterr().err.splitlines() if "cannot be written any further" in line]
    assert len(said) == 1 and "file too large" in said[0]
    assert path.stat().st_size <= 8000
    recording = open_recording(path)
    if recording.counts.get("/fast"):
        count = recording.counts["/fast"]
        assert [m.cycle for m in recording.messages("/fast")] == list(range(count))


def test_messages_that_fit_no_topic_are_left_out(tmp_path: Path) -> None:
    ring = SharedRing(f"test-drain-{os.getpid()}", 1 << 16, create=True)
    said: list[str] = []
    drain = Drain(ring, RecordingWriter(tmp_path / "a.mcap", HEADER), said.append)
    for message in (b"", b"\xff", b"\x00", b"\x00\xc1", b"\x00\x93\x01\x02\x03"):
        ring.put(message)
    ring.put(bytes([LOG]) + b"\x83\xa6time_s\xcb?\xf0\0\0\0\0\0\0\xa5level\xa1i\xa4text\xa1t")
    drain.finish()
    ring.close()
    assert len(said) == 1 and not drain.failed
    assert list(open_recording(tmp_path / "a.mcap").messages("/log")) == [LogLine(1.0, "i", "t")]


def test_a_recorder_that_crashes_at_its_start_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(UserError, match="ended before it began"):
        RecorderClient.start(tmp_path / "a.mcap", HEADER)


class FullDisk(io.BytesIO):
    """A file on a disk with so much room, then ENOSPC; a write that does not fit writes what fits, as write(2)."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def write(self, data: object) -> int:
        """Up to the room that is left."""
        view = memoryview(data)[: max(0, self.room - self.tell())]  # type: ignore[arg-type]
        if not view:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(view)


@pytest.mark.parametrize("room", [3_000, 20_000, 60_000])
def test_a_disk_that_fills_up_keeps_all_but_the_last_half_second(tmp_path: Path, room: int) -> None:
    """And it is said, once, with what can be read; `recover` makes a complete file of it."""
    disk, said = FullDisk(room), list[str]()
    ring = SharedRing(f"test-full-{os.getpid()}", 1 << 20, create=True)
    drain = Drain(ring, RecordingWriter(disk, HEADER), said.append)
    failed_at = None
    for i in range(20_000):
        ring.put(bytes([FAST]) + msgspec.msgpack.encode(FastSample(i * 0.001, i, i / 7)))
        if i % 30 == 29:
            drain.drain()
        if i % 500 == 499:
            drain.flush()
        if drain.failed and failed_at is None:
            failed_at = i
    drain.finish()
    ring.close()
    assert failed_at is not None and len(said) == 1 and "no space left" in said[0]
    cut, mended = tmp_path / "cut.mcap", tmp_path / "mended.mcap"
    cut.write_bytes(disk.getvalue())
    recover(cut, mended)
    after = open_recording(mended)
    assert not after.cut
    kept = [message.cycle for message in after.messages("/fast")] if after.counts.get("/fast") else []
    assert kept == list(range(len(kept)))
    assert failed_at - len(kept) <= 1000
