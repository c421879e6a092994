"""The WebSocket of a page: sends the messages of its queue and answers pings. It takes nothing else."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Any

import msgspec
from aiohttp import WSMsgType, web

from stillarm.panel.server.guard import Guard, error_response
from stillarm.panel.server.rate import RateLimit
from stillarm.panel.server.subscribers import Subscriber, Subscribers

_MOST_BYTES = 1024  # of a page's message
_SEND_WITHIN_S = 10.0  # a page that has read nothing for so long is closed
_HEARTBEAT_S = 20.0
_PINGS_PER_S, _PINGS_AT_ONCE = 10.0, 30


class _Ping(msgspec.Struct, forbid_unknown_fields=True):
    ping: float
    beside: list[str] = []
    """Methods that the page wants drawn beside the one in force; heard from a page with a session."""


_PING = msgspec.json.Decoder(_Ping)
_ENCODE = msgspec.json.Encoder().encode


def socket_handler(
    guard: Guard, pages: Subscribers, first: Callable[[bool], list[str]]
) -> Callable[[web.Request], Any]:
    """The handler. first: the messages that a new page begins with, given whether it is signed in."""

    async def handler(request: web.Request) -> web.StreamResponse:
        queue = pages.add()
        if queue is None:
            return error_response(503, "too many open pages; close some")
        try:
            socket = web.WebSocketResponse(
                max_msg_size=_MOST_BYTES, heartbeat=_HEARTBEAT_S, compress=False, timeout=2.0
            )
            await socket.prepare(request)
            for message in first(guard.signed_in(request)):
                queue.put(message)
            sending = asyncio.create_task(_send(socket, queue))
            try:
                await _answer_pings(socket, queue, may_want=guard.signed_in(request))
            finally:
                sending.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await sending
            return socket
        finally:
            pages.remove(queue)

    return handler


async def _send(socket: web.WebSocketResponse, queue: Subscriber) -> None:
    """Until the page is gone, or has not read for too long."""
    try:
        while True:
            message = await queue.get()
            async with asyncio.timeout(_SEND_WITHIN_S):
                if isinstance(message, str):
                    await socket.send_str(message)
                else:
                    await socket.send_bytes(message)
    except (TimeoutError, ConnectionError, RuntimeError):
        with contextlib.suppress(ConnectionError, RuntimeError):
            await socket.close()


async def _answer_pings(socket: web.WebSocketResponse, queue: Subscriber, *, may_want: bool) -> None:
    """Each ping gets the server's monotonic time, s, by which the page dates the samples."""
    limit = RateLimit(_PINGS_PER_S, _PINGS_AT_ONCE)
    async for message in socket:
        if message.type is not WSMsgType.TEXT or not limit.allows("", time.monotonic()):
            await socket.close(code=1008, message=b"only pings are taken, ten a second")
            return
        try:
            ping = _PING.decode(message.data)
        except (msgspec.DecodeError, msgspec.ValidationError):
            await socket.close(code=1008, message=b"this is no ping")
            return
        if may_want:
            queue.beside = frozenset(ping.beside)
        queue.put(_ENCODE({"type": "pong", "ping": ping.ping, "server_s": time.monotonic()}).decode())
