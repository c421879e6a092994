"""Telemetry for a live view: the recorder's messages as msgpack maps in batches, as PlotJuggler reads them.

docs/telemetry.md describes the datagrams. Sent by the recorder's process, never by the loop.
"""

import contextlib
import socket
from collections.abc import Callable
from typing import Any

import msgspec

from stillarm.common.datagrams.fields import plain_types
from stillarm.common.files.configuration import Telemetry
from stillarm.common.recording.topics import TOPIC_INDEX, TOPICS, EstimateSample

_MOST_BYTES = 60_000  # a UDP datagram holds 65507
_ENCODE = msgspec.msgpack.Encoder().encode
_PLOTTED = {
    topic.name: [
        name
        for name, plain in plain_types(topic.message).items()
        if plain in (float, int, bool) and name != "time_s"
    ]
    for topic in TOPICS
}
"""The fields that have a place in a plot, by topic."""
TELEMETRY_TOPICS = [t for t in TOPICS if t.source.startswith("controller") and _PLOTTED[t.name]]


def telemetry_map(topic_name: str, message: Any) -> dict[str, object]:
    """{"time_s": ..., TOPIC: {field: number or bool, ...}}; texts and lists have no place in a plot and are left out.

    For /estimate, whether the damping is active stands for its status.
    """
    fields = {name: getattr(message, name) for name in _PLOTTED[topic_name]}
    if isinstance(message, EstimateSample):
        fields["damping_active"] = message.damping_status == "active"
    return {"time_s": message.time_s, TOPICS[TOPIC_INDEX[topic_name]].short_name: fields}


class TelemetryBatches:
    """Collects maps and gives them out as datagrams every period. Pure: messages and times in, bytes out."""

    def __init__(self, settings: Telemetry) -> None:
        """Nothing collected yet."""
        self._settings = settings
        self._maps: list[bytes] = []
        self._bytes = 0
        self._full: list[bytes] = []
        self._next_s = float("-inf")

    def take(self, topic_name: str, message: Any) -> None:
        """Collect one message; of those of every cycle, each `every_cycles`-th."""
        topic = TOPICS[TOPIC_INDEX[topic_name]]
        if not _PLOTTED[topic_name] or (topic.every_cycle and message.cycle % self._settings.every_cycles):
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


def telemetry_sender(host: str, port: int) -> Callable[[bytes], None]:
    """Sends a datagram to the listeners; nobody listening, or no such host, is no error."""
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setblocking(False)

    def send(datagram: bytes) -> None:
        with contextlib.suppress(OSError):
            sender.sendto(datagram, (host, port))

    return send
