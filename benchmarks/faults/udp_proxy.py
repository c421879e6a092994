"""A proxy on the real links between the processes. It applies link faults and records commands."""

import contextlib
import heapq
import random
import select
import socket
import time
from dataclasses import dataclass, field

from stillarm.benchmarks.faults.faulty_link import PERFECT, LinkFault, faulty_link
from stillarm.common.datagrams.datagram import DEMO_KEY, Datagram, decode
from stillarm.common.datagrams.messages import DriveCommand

_HOST = "127.0.0.1"
_REMEMBERED = 2000


@dataclass
class _Way:
    """One direction: datagrams that arrive at one socket leave from another one."""

    into: socket.socket
    out: socket.socket
    to: tuple[str, int]
    fault: LinkFault = PERFECT
    past: list[bytes] = field(default_factory=list)


class UdpProxy:
    """The proxy between controller and supervisor, and between controller and gateway. It works while pump() runs."""

    def __init__(
        self, *, controller_port: int, supervisor_port: int, gateway_port: int, drive_port: int, seed: int
    ) -> None:
        """The arguments are the ports on which the processes listen."""
        self._rng = random.Random(seed)
        sockets = [_bound() for _ in range(4)]
        self.supervisor_port, self.controller_port, self.gateway_port, _ = (
            s.getsockname()[1] for s in sockets
        )
        as_supervisor, as_controller, as_gateway, as_drive = sockets
        self.down = _Way(as_supervisor, as_controller, (_HOST, supervisor_port))
        self.up = _Way(as_controller, as_supervisor, (_HOST, controller_port))
        self.commands = _Way(as_gateway, as_drive, (_HOST, gateway_port))
        self.states = _Way(as_drive, as_gateway, (_HOST, drive_port))
        self._ways = {way.into: way for way in (self.down, self.up, self.commands, self.states)}
        self._flying: list[tuple[float, int, _Way, bytes]] = []
        self._count = 0
        self.seen: list[tuple[float, float]] = []
        """Every command that passed, with the monotonic time: s, rad/s."""

    def pump(self, seconds: float) -> None:
        """Pass datagrams on for a duration."""
        until = time.monotonic() + seconds
        while (now := time.monotonic()) < until:
            while self._flying and self._flying[0][0] <= now:
                _, _, way, data = heapq.heappop(self._flying)
                self._send(way, data)
            wait = until - now
            if self._flying:
                wait = min(wait, max(0.0, self._flying[0][0] - now))
            for ready in select.select(list(self._ways), [], [], wait)[0]:
                self._take(self._ways[ready])

    def forget(self) -> None:
        """Drop all waiting datagrams, which come from a process that has ended and is about to be restarted."""
        self._flying.clear()
        for way in self._ways.values():
            with contextlib.suppress(BlockingIOError, ConnectionError):
                while True:
                    way.into.recv(2000)

    def _take(self, way: _Way) -> None:
        for _ in range(64):
            try:
                data = way.into.recv(2000)
            except (BlockingIOError, ConnectionError):
                return
            now = time.monotonic()
            if way.fault is PERFECT:
                self._send(way, data)
            else:
                for delay, arriving in faulty_link(way.fault, data, way.past, self._rng):
                    self._count += 1
                    heapq.heappush(self._flying, (now + delay, self._count, way, arriving))
            if len(way.past) < _REMEMBERED:
                way.past.append(data)

    def _send(self, way: _Way, data: bytes) -> None:
        if way is self.commands:
            datagram = decode(DEMO_KEY, data)
            if isinstance(datagram, Datagram) and isinstance(datagram.body, DriveCommand):
                self.seen.append((time.monotonic(), datagram.body.velocity_rad_s))
        try:
            way.out.sendto(data, way.to)
        except OSError:  # the datagram is too long, or nobody listens
            return

    def close(self) -> None:
        """Release the ports."""
        for way in self._ways.values():
            way.into.close()


def _bound() -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind((_HOST, 0))
    made.setblocking(False)
    return made
