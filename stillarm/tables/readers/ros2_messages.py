"""ROS 2 messages (CDR) by the package rosbags, with the definition that the recording carries."""

import importlib
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

_MANY = 4096  # values in an array: beyond these it is an image or a cloud


def cdr_decoder(name: str, encoding: str, definition: bytes) -> tuple[Callable[[bytes], Any] | None, str]:
    """A decoder of one message type into plain dicts and lists, or None with the reason.

    name: 'sensor_msgs/msg/JointState'; encoding: of the definition, 'ros2msg' or 'ros2idl'.
    """
    try:
        typesys = importlib.import_module("rosbags.typesys")
    except ImportError:
        return None, (
            "ROS 2 messages: needs the package rosbags; `pip install 'stillarm[rosbag]'` or "
            "`pip install rosbags`; left out"
        )
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    text = definition.decode("utf-8", errors="replace")
    try:
        if encoding == "ros2msg":
            kinds = typesys.get_types_from_msg(text, name)
        elif encoding == "ros2idl":
            kinds = typesys.get_types_from_idl(text)
        else:
            return None, f"schema encoding {encoding[:20]!r} is not read (ros2msg, ros2idl); left out"
        store.register(kinds)
    except Exception as error:  # a definition by anybody
        return None, f"its definition of {name} is not read ({' '.join(str(error).split())[:60]}); left out"
    return lambda data: _plain(store.deserialize_cdr(data, name)), ""


def _plain(value: Any) -> Any:
    """A message as dicts, lists and numbers."""
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value) if f.name != "__msgtype__"}
    if hasattr(value, "tolist"):
        return value.tolist() if value.size <= _MANY else None
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value] if len(value) <= _MANY else None
    return value
