"""Blocks of killed processes go; those that anybody has mapped, or that are new, stay."""

import os
import secrets
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stillarm.common.memory.left_behind import mapped_blocks, remove_left_blocks
from stillarm.common.memory.shared_memory import SharedBlock, block_path

ROOT = Path(__file__).parents[3]


@pytest.mark.slow
def test_a_killed_process_leaves_a_block_and_the_next_start_removes_it() -> None:
    name = f"left-{os.getpid()}-{secrets.token_hex(4)}"
    code = (
        "import sys, time; from stillarm.common.memory.shared_memory import SharedBlock\n"
        "block = SharedBlock(sys.argv[1], 4096, create=True); print('made', flush=True); time.sleep(600)"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, name], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None and process.stdout.readline() == "made\n"
    path = block_path(name)
    assert path.stat().st_ino in mapped_blocks()
    assert path.name not in remove_left_blocks(older_than_s=-1.0)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert path.name not in remove_left_blocks()  # it is new: somebody may be about to open it
    assert path.exists()
    path_only = [path.name]
    assert [x for x in remove_left_blocks(older_than_s=-1.0) if x in path_only] == path_only
    assert not path.exists()


def test_a_block_that_only_its_reader_has_mapped_stays() -> None:
    """Its maker is gone; the recorder still empties it."""
    name = f"left-{os.getpid()}-{secrets.token_hex(4)}"
    made = SharedBlock(name, 64, create=True)
    reader = SharedBlock(name, create=False)
    made._owner = False
    made.close()
    assert block_path(name).name not in remove_left_blocks(older_than_s=-1.0)
    reader.close()
    block_path(name).unlink()
