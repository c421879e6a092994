"""A message of any nesting as flat numbers: {"pose": {"x": 1}} becomes {"pose.x": 1}. Pure.

Seconds and nanoseconds side by side (ROS, Foxglove) are one instant in ns. Lists that stand beside a list of names of
their length (sensor_msgs/JointState) take those names: position.shoulder. A list longer than MAX_LIST is an image or a
cloud, and left out.
"""

from collections.abc import Iterator
from typing import Any

MAX_LIST = 64
INSTANT_SUFFIX = "_ns"
_NANOSECONDS = ("nanosec", "nsec", "nanoseconds", "nanos")
_SECONDS = ("sec", "secs", "seconds")
_DEPTH = 12


def flat(message: Any) -> dict[str, float | int]:
    """Every number of a message by its path."""
    return dict(_numbers(message, "", _DEPTH))


def _numbers(value: Any, path: str, depth: int) -> Iterator[tuple[str, float | int]]:
    if isinstance(value, bool | int | float):
        yield path or "value", int(value) if isinstance(value, bool) else value
    elif depth == 0:
        return
    elif isinstance(value, dict):
        instant = _instant(value)
        if instant is not None:
            yield f"{path}{INSTANT_SUFFIX}", instant
            return
        names = _names(value)
        for key, part in value.items():
            labels = names if isinstance(part, list) and len(part) == len(names) else []
            yield from _listed(part, f"{path}.{key}" if path else str(key), labels, depth - 1)
    elif isinstance(value, list):
        yield from _listed(value, path, [], depth - 1)


def _listed(value: Any, path: str, labels: list[str], depth: int) -> Iterator[tuple[str, float | int]]:
    if not isinstance(value, list):
        yield from _numbers(value, path, depth)
    elif len(value) <= MAX_LIST:
        for index, part in enumerate(value):
            yield from _numbers(part, f"{path}.{labels[index]}" if labels else f"{path}[{index}]", depth)


def _instant(value: dict[str, Any]) -> int | None:
    if len(value) != 2:
        return None
    seconds = next((value[key] for key in _SECONDS if key in value), None)
    nanoseconds = next((value[key] for key in _NANOSECONDS if key in value), None)
    if isinstance(seconds, int) and isinstance(nanoseconds, int):
        return seconds * 1_000_000_000 + nanoseconds
    return None


def _names(value: dict[str, Any]) -> list[str]:
    for key in ("name", "names", "joint_names"):
        found = value.get(key)
        if isinstance(found, list) and found and all(isinstance(name, str) for name in found):
            return found if len(set(found)) == len(found) else []
    return []
