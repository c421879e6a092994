"""Telemetry for a live view: the recorder's messages as msgpack maps in batches, as PlotJuggler reads them.

docs/telemetry.md describes the datagrams. Sent by the recorder's process, never by the loop.
"""

import contextlib
import socket
from collections.abc import Callable

import msgspec

from common.configuration import Telemetry

_MOST_BYTES = 60_000  # a UDP datagram holds 65507
_ENCODE = msgspec.msgpack.Encoder().encode
_EVERY_CYCLE = ("/fast", "/estimate")


def telemetry_map(topic_name: str, message: msgspec.Struct) -> dict[str, object]:
    """{"time_s": ..., TOPIC: {field: number or bool, ...}}; texts and lists have no place in a plot and are left out.

    For /estimate, whether the damping is active stands for its status.
    """
    fields: dict[str, float | bool] = {}
    for name in message.__struct_fields__:
        value = getattr(message, name)
        if isinstance(value, float | int) and name != "time_s":
            fields[name] = value
    status = getattr(message, "damping_status", None)
    if status is not None:
        fields["damping_active"] = status == "active"
    return {"time_s": message.time_s, topic_name.strip("/").replace("/", "_"): fields}  # type: ignore[attr-defined]


class TelemetryBatches:
    """Collects maps and gives them out as datagrams every period. Pure: messages and times in, bytes out."""

    def __init__(self, settings: Telemetry) -> None:
        """Nothing collected yet."""
        self._settings = settings
        self._maps: list[bytes] = []
        self._bytes = 0
        self._full: list[bytes] = []
        self._next_s = float("-inf")

    def take(self, topic_name: str, message: msgspec.Struct) -> None:
        """Collect one message; of those of every cycle, each `every_cycles`-th."""
        if topic_name == "/log":  # nothing but text
            return
        if topic_name in _EVERY_CYCLE and message.cycle % self._settings.every_cycles:  # type: ignore[attr-defined]
            return
        encoded = _ENCODE(telemetry_map(topic_name, message))
        if len(encoded) > _MOST_BYTES:
            return
        if self._bytes + len(encoded) > _MOST_BYTES:
            self._close_batch()
        self._maps.append(encoded)
        self._bytes += len(encoded)

    def due(self, now_s: float) -> list[bytes]:
        """The datagrams to send now; none before a period has passed since the last ones."""
        if now_s < self._next_s:
            return []
        self._next_s = now_s + self._settings.period_s
        self._close_batch()
        full, self._full = self._full, []
        return full

    def _close_batch(self) -> None:
        if self._maps:
            head = b"\xdc" + len(self._maps).to_bytes(2, "big")  # a msgpack array of so many
            self._full.append(head + b"".join(self._maps))
            self._maps, self._bytes = [], 0


def telemetry_sender(settings: Telemetry) -> Callable[[bytes], None]:
    """What sends a datagram to whoever listens; nobody listening, or no such host, is no error."""
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setblocking(False)

    def send(datagram: bytes) -> None:
        with contextlib.suppress(OSError):
            sender.sendto(datagram, (settings.host, settings.port))

    return send
