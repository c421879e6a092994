"""Commands and the hold reach a controller's end of the link, and end when they should."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Link
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError
from stillarm.controller.input.exchange import ReferenceExchange
from stillarm.controller.safety.table import Operator
from stillarm.panel.operate.sender import Commands


class Controller:
    """The controller's reference socket, read every millisecond."""

    def __init__(self, port: int) -> None:
        self.exchange = ReferenceExchange(DEMO_KEY, new_session())
        self.socket = UdpSocket(("127.0.0.1", port), "test")
        self.asked = 0

    async def run(self) -> None:
        while True:
            for data, sender in self.socket.drain_with_senders(32):
                self.exchange.take([data], time.monotonic())
                if answer := self.exchange.hello():
                    self.socket.send(answer, sender)
            self.asked |= self.exchange.asked()
            await asyncio.sleep(0.001)

    @property
    def allowed(self) -> bool:
        return self.exchange.reference(time.monotonic())[1]


@asynccontextmanager
async def controller(port: int) -> AsyncIterator[Controller]:
    made = Controller(port)
    running = asyncio.create_task(made.run())
    try:
        yield made
    finally:
        running.cancel()
        made.socket.close()


@pytest.fixture
def port() -> int:
    held = UdpSocket(("127.0.0.1", 0), "test")
    number = int(held._socket.getsockname()[1])
    held.close()
    return number


async def until(holds: object) -> None:
    async with asyncio.timeout(3.0):
        while not holds():  # type: ignore[operator]
            await asyncio.sleep(0.002)


def test_a_command_is_taken_once_its_sender_is_known(port: int) -> None:
    async def run() -> int:
        async with controller(port) as made:
            await Commands(Link(reference_port=port)).send(int(Operator.DISARM))
            await asyncio.sleep(0.01)
            return made.asked

    assert asyncio.run(run()) == Operator.DISARM


def test_an_adjustment_reaches_the_controller(port: int) -> None:
    async def run() -> Adjustment | None:
        async with controller(port) as made:
            await Commands(Link(reference_port=port)).adjust(Adjustment("fused", 0.1))
            await asyncio.sleep(0.01)
            return made.exchange.adjustment()

    assert asyncio.run(run()) == Adjustment("fused", 0.1)


def test_damping_is_held_until_cancelled_and_lapses_then(port: int) -> None:
    async def run() -> None:
        async with controller(port) as made:
            commands = Commands(Link(reference_port=port))
            holding = asyncio.create_task(commands.hold_damping(lambda: made.allowed))
            await until(lambda: not made.allowed)
            await commands.send(int(Operator.ARM))  # does not take the hold's place
            await asyncio.sleep(0.15)
            assert not made.allowed
            holding.cancel()
            await until(lambda: made.allowed)

    asyncio.run(run())


def test_a_restarted_controller_is_held_again(port: int) -> None:
    async def run() -> None:
        allowed = True
        commands = Commands(Link(reference_port=port))
        holding = asyncio.create_task(commands.hold_damping(lambda: allowed))
        try:
            for _ in range(2):
                async with controller(port) as made:
                    await until(lambda made=made: not made.allowed)
        finally:
            holding.cancel()

    asyncio.run(run())


@pytest.mark.slow
def test_no_controller_is_told_with_the_address(port: int) -> None:
    with pytest.raises(UserError, match=f"no controller answers at 127.0.0.1:{port}"):
        asyncio.run(Commands(Link(reference_port=port)).send(1))
