"""The telemetry for Foxglove by its own WebSocket protocol (https://docs.foxglove.dev/docs/sdk), a channel a topic.

Messages are made only while somebody subscribes to their channel. The server takes nothing from its clients.
"""

import logging
from math import isfinite
from typing import Any, NamedTuple

import msgspec

from stillarm.common.recording.topics import TOPICS
from stillarm.common.user_error import UserError

SENT = ("fast", "estimate", "frames", "link", "words")
"""The maps of docs/telemetry.md that become channels, /fast and so on; words, which are texts, as /words."""
_TYPES: dict[object, str] = {bool: "boolean", int: "integer", float: "number", str: "string"}
_DECODER = msgspec.msgpack.Decoder(list[dict[str, Any]])


def require_foxglove() -> Any:
    """The SDK's module. Raises UserError where it is not installed."""
    try:
        import foxglove
    except ImportError:
        raise UserError(
            "--foxglove-port: needs foxglove-sdk; install it with `pip install 'stillarm[foxglove]'`"
        ) from None
    logging.getLogger("foxglove").setLevel(logging.ERROR)
    return foxglove


def finite(fields: dict[str, Any]) -> dict[str, Any]:
    """The fields as JSON holds them: null where there is no finite number, as in a recording."""
    return {k: None if isinstance(v, float) and not isfinite(v) else v for k, v in fields.items()}


def schema_of(topic: str) -> dict[str, Any]:
    """The JSON schema of a topic's map: its numbers, with time_s first. /words has texts only."""
    message = next((t.message for t in TOPICS if t.short_name == topic), None)
    fields = {} if message is None else {f.name: f.type for f in msgspec.structs.fields(message)}
    typed = {name: _TYPES.get(_plain(kind), "number") for name, kind in fields.items()}
    numbers = {name: {"type": kind} for name, kind in typed.items() if kind != "string"}
    return {"type": "object", "title": topic, "properties": {"time_s": {"type": "number"}} | numbers}


def _plain(kind: Any) -> object:
    """The type without what is annotated to it."""
    return getattr(kind, "__origin__", kind)


class PemFiles(NamedTuple):
    """The contents of a certificate's file and of its private key's (PKCS#8)."""

    certificate: bytes
    key: bytes


class FoxgloveBridge:
    """A server of the protocol, fed with the telemetry's datagrams."""

    def __init__(self, host: str, port: int, tls: PemFiles | None = None) -> None:
        """Listen on host:port; port 0: a free one. tls: for wss.

        Raises UserError without the SDK, where the port is taken, or the files cannot be used.
        """
        foxglove = require_foxglove()
        self._context = context = foxglove.Context()  # kept: the channels end with it
        self._channels = {
            topic: foxglove.Channel(f"/{topic}", schema=schema_of(topic), context=context) for topic in SENT
        }
        try:
            secured = {} if tls is None else {"tls_cert": tls.certificate, "tls_key": tls.key}
            self._server = foxglove.start_server(
                name="stillarm", host=host, port=port, context=context, **secured
            )
        except (OSError, RuntimeError, ValueError) as error:
            raise UserError(
                f"--foxglove-port {port}: cannot listen on {host} ({error}); choose another port"
                + (", or give --key in PKCS#8 form (BEGIN PRIVATE KEY)" if tls is not None else "")
            ) from None

    @property
    def port(self) -> int:
        """The port listened on."""
        return int(self._server.port)

    def take(self, datagram: bytes, arrived_ns: int) -> None:
        """Hand one datagram's maps to who subscribes. arrived_ns: Unix time, ns; the newest map gets it."""
        if not any(channel.has_sinks() for channel in self._channels.values()):
            return
        try:
            maps = _DECODER.decode(datagram)
        except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError):
            return
        newest_s = max((float(one.get("time_s", 0.0)) for one in maps), default=0.0)
        for one in maps:
            time_s = float(one.get("time_s", newest_s))
            for topic, channel in self._channels.items():
                fields = one.get(topic)
                if isinstance(fields, dict) and channel.has_sinks():
                    log_time = arrived_ns - round((newest_s - time_s) * 1e9)
                    channel.log({"time_s": time_s} | finite(fields), log_time=log_time)

    def close(self) -> None:
        """Stop listening."""
        self._server.stop()
