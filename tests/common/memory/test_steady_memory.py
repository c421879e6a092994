"""Objects of a warmed-up process are not collected, and its memory is locked where that is allowed."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SCRIPT = """
import gc, resource
from stillarm.common.memory.steady_memory import settle_memory
locked = settle_memory()
held = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmLck"))
print(gc.get_freeze_count() > 1000, len(gc.get_objects()) < 1000, gc.isenabled(), locked, held != "0")
"""


@pytest.mark.slow
def test_what_was_imported_is_frozen_and_the_collector_goes_on() -> None:
    """In a process of its own: this one is to stay as it is. Locked is what the kernel says is locked."""
    said = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()
    assert said[:3] == ["True", "True", "True"]
    assert said[3] == said[4]
