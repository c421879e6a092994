"""Memory between processes: whole values only, whole messages in order, nothing left behind."""

import os
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stillarm.common.memory.shared_memory import SharedBlock, SharedRing, block_path
from stillarm.common.user_error import UserError

ROOT = Path(__file__).parents[3]


@pytest.fixture
def name(request: pytest.FixtureRequest) -> Iterator[str]:
    chosen = f"test-memory-{os.getpid()}-{abs(hash(request.node.name)) % 10**8}"
    yield chosen
    assert not block_path(chosen).exists(), "left behind"


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    size=st.integers(8, 64),
    steps=st.lists(st.integers(0, 40).map(lambda n: ("put", n)) | st.just(("get", 0)), max_size=80),
)
def test_a_ring_is_a_queue_that_may_refuse(name: str, size: int, steps: list[tuple[str, int]]) -> None:
    writer = SharedRing(name, size, create=True)
    reader = SharedRing(name, create=False)
    held: deque[bytes] = deque()
    refused = 0
    for number, (step, length) in enumerate(steps):
        if step == "get":
            assert reader.get() == (held.popleft() if held else None)
            continue
        message = bytes([number % 256]) * length
        empty = not held
        if writer.put(message):
            held.append(message)
        else:
            refused += 1
            # Room is there when the ring is empty, for what is no longer than half of it wherever the ring
            # stands.
            assert not (empty and 2 * (length + 4) <= size)
    while held:
        assert reader.get() == held.popleft()
    assert reader.get() is None
    assert writer.lost == reader.lost_by_writer == refused
    reader.close()
    writer.close()


@pytest.mark.slow
def test_a_ring_outlives_a_killed_writer(name: str) -> None:
    ring = SharedRing(name, 1 << 16, create=True)
    code = (
        "import os, sys; from stillarm.common.memory.shared_memory import SharedRing\n"
        f"ring = SharedRing({name!r}, create=False)\n"
        "for i in range(1000): ring.put(str(i).encode())\n"
        "os.kill(os.getpid(), 9)"
    )
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == -9
    assert [ring.get() for _ in range(1001)] == [*(str(i).encode() for i in range(1000)), None]
    ring.close()


def test_a_block_made_anew_is_noticed(name: str) -> None:
    first = SharedBlock(name, 16, create=True)
    reader = SharedBlock(name, create=False)
    assert reader.size == 16 and not reader.replaced()
    second = SharedBlock(name, 32, create=True)
    assert reader.replaced() and bytes(second.buffer) == bytes(32)
    first.close()
    assert block_path(name).exists(), "the predecessor removed its successor's block"
    for block in (reader, second, first):
        block.close()
        block.close()
    assert reader.replaced()


@pytest.mark.parametrize("bad", ["", "a/b", "../x", "a b", "é"])
def test_names_that_are_no_words_are_refused(bad: str) -> None:
    with pytest.raises(UserError, match="shared memory name"):
        SharedBlock(bad, 8, create=True)


def test_a_block_that_is_not_there_is_an_error(name: str) -> None:
    with pytest.raises(UserError, match="not there"):
        SharedBlock(name, create=False, wait_s=0.02)
    block_path(name).write_bytes(bytes(100))  # one that is still being made
    with pytest.raises(UserError, match="not there"):
        SharedBlock(name, create=False)
    block_path(name).unlink()


def test_memory_that_is_not_there_is_an_error_at_once(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not a fatal signal at the first write, in the middle of a cycle."""

    def full(descriptor: int, offset: int, length: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(UserError, match="no space left on device") as refused:
        SharedBlock(name, 1000, create=True)
    assert "\n" not in str(refused.value)
