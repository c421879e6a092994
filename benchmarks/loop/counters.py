"""Finds a running controller's counters."""

from stillarm.common.memory.shared_memory import block_path


def block_name(controller: int) -> str | None:
    """Name of the counters of the controller with that process id; None before they exist."""
    pattern = block_path(f"loop-{controller}-x").name[:-1] + "*"
    found = next(iter(block_path("x").parent.glob(pattern)), None)
    return None if found is None else found.name.removeprefix("stillarm-")
