"""Signs and sends an operator's commands to the controller, as `stillarm operate` does, without blocking the server."""

import asyncio
import time
from collections.abc import Callable

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Link
from stillarm.common.link.link_key import load_key
from stillarm.common.link.operator_sender import OperatorSender
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError

_ANSWER_WITHIN_S = 1.0
_ASK_EVERY_S = 0.004
_REPEATS = 3
_RENEW_S = 0.03  # a reference lapses after 0.1 s
_HELD_WITHIN_S = 0.5


class Commands:
    """The way to one controller."""

    def __init__(self, link: Link) -> None:
        """Opens nothing. Raises UserError for a key that cannot be read."""
        self._key = load_key(link)
        self._controller = (link.controller_host, link.reference_port)
        self._local = link.controller_host if link.controller_host.startswith("127.") else "0.0.0.0"

    async def send(self, bits: int) -> None:
        """Send a command, bits of stillarm.controller.safety.table.Operator. Raises UserError when nobody answers."""
        await self._send(lambda sender: sender.command(bits))

    async def adjust(self, asked: Adjustment) -> None:
        """Ask for another method or gain. Raises UserError when nobody answers."""
        await self._send(lambda sender: sender.adjustment(asked.method, asked.added_damping_ratio))

    async def _send(self, packed: Callable[[OperatorSender], bytes]) -> None:
        socket = UdpSocket((self._local, 0), "panel")
        try:
            sender = await self._met(socket, packed)
            for _ in range(_REPEATS):
                socket.send(packed(sender), self._controller)
                await asyncio.sleep(_ASK_EVERY_S)
        finally:
            socket.close()

    async def _met(self, socket: UdpSocket, packed: Callable[[OperatorSender], bytes]) -> OperatorSender:
        """A sender of a new session, once the controller has answered it."""
        sender = OperatorSender(self._key, new_session())
        deadline = time.monotonic() + _ANSWER_WITHIN_S
        while not sender.known:
            if time.monotonic() > deadline:
                host, port = self._controller
                raise UserError(f"no controller answers at {host}:{port}; start it with this configuration")
            socket.send(packed(sender), self._controller)
            await asyncio.sleep(_ASK_EVERY_S)
            sender.take(socket.drain(16))
        return sender

    async def hold_damping(self, still_allowed: Callable[[], bool]) -> None:
        """Tell the controller that damping is not allowed, again and again until cancelled.

        still_allowed: whether the controller says that damping is allowed. If it does for long, somebody else's command
        has taken this session's place, and a new one begins.
        """
        socket = UdpSocket((self._local, 0), "panel")
        try:
            while True:
                try:
                    sender = await self._met(socket, lambda sender: sender.reference(0.0, False))
                except UserError:
                    continue  # no controller: the next one is held as well
                in_vain_since = time.monotonic()
                while time.monotonic() - in_vain_since < _HELD_WITHIN_S:
                    socket.send(sender.reference(0.0, False), self._controller)
                    await asyncio.sleep(_RENEW_S)
                    if not still_allowed():
                        in_vain_since = time.monotonic()
        finally:
            socket.close()
