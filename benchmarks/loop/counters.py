"""Where a running controller's counters are."""

from common.shared_memory import block_path


def block_name(controller: int) -> str | None:
    """The name of the counters of the controller with that process number; None before it has made them."""
    pattern = block_path(f"loop-{controller}-x").name[:-1] + "*"
    found = next(iter(block_path("x").parent.glob(pattern)), None)
    return None if found is None else found.name.removeprefix("stillarm-")
