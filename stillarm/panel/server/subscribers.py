"""The queue to each open page. A page that reads slowly loses the oldest messages; nobody waits for it."""

import asyncio
from collections import deque

MOST_QUEUED = 64  # messages: two seconds of telemetry
MOST_BYTES = 4 << 20
MOST_PAGES = 128


class Subscriber:
    """One page's queue."""

    def __init__(self) -> None:
        """Empty."""
        self._messages: deque[bytes | str] = deque()
        self._bytes = 0
        self._waiting = asyncio.Event()
        self.beside: frozenset[str] = frozenset()
        """The methods that the page wants drawn beside the one in force."""
        self.dropped = 0
        """Messages that were dropped because the page did not read."""

    def put(self, message: bytes | str) -> None:
        """Add a message, and drop the oldest ones where there are too many. Never waits."""
        self._messages.append(message)
        self._bytes += len(message)
        while len(self._messages) > MOST_QUEUED or (self._bytes > MOST_BYTES and len(self._messages) > 1):
            self._bytes -= len(self._messages.popleft())
            self.dropped += 1
        self._waiting.set()

    async def get(self) -> bytes | str:
        """The oldest message; waits for one."""
        while not self._messages:
            self._waiting.clear()
            await self._waiting.wait()
        message = self._messages.popleft()
        self._bytes -= len(message)
        return message


class Subscribers:
    """All open pages."""

    def __init__(self, most: int = MOST_PAGES) -> None:
        """most: pages at the same time."""
        self._most = most
        self._all: set[Subscriber] = set()

    def __len__(self) -> int:
        """How many pages are open."""
        return len(self._all)

    def add(self) -> Subscriber | None:
        """A queue for another page; None where there are too many."""
        if len(self._all) >= self._most:
            return None
        subscriber = Subscriber()
        self._all.add(subscriber)
        return subscriber

    def remove(self, subscriber: Subscriber) -> None:
        """The page has closed."""
        self._all.discard(subscriber)

    def beside(self) -> frozenset[str]:
        """The methods that any page wants drawn beside the one in force."""
        return frozenset().union(*(one.beside for one in self._all))

    def put(self, message: bytes | str) -> None:
        """Send a message to every page."""
        for subscriber in self._all:
            subscriber.put(message)
