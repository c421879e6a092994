"""Feeds every open page: telemetry as it comes, and the status on change and once a second. Edge: the clock."""

import time
from collections.abc import Callable
from typing import Any

import msgspec

from stillarm.panel.live.known import Known
from stillarm.panel.live.packing import pack_rows
from stillarm.panel.live.telemetry import rows_of
from stillarm.panel.live.view import VIEW_MARK, view_message
from stillarm.panel.server.subscribers import Subscribers

_STATUS_EVERY_S = 1.0
_ENCODE = msgspec.json.Encoder().encode
Status = Callable[[Known, float], dict[str, Any]]


class Feed:
    """Takes datagrams, keeps what is known, and fills the pages' queues."""

    def __init__(self, status: Status, clock: Callable[[], float] = time.monotonic) -> None:
        """status: what is told beside the curves, from what is known and the time; clock: s."""
        self.known = Known()
        self.pages = Subscribers()
        self._status, self._clock = status, clock
        self._sent: dict[str, Any] = {}
        self._due_s = float("-inf")

    def take(self, datagram: bytes) -> None:
        """One datagram of telemetry, or a view from the supervisor."""
        if datagram.startswith(VIEW_MARK):
            message = view_message(datagram)
            if message is not None:
                self.pages.put(message)
            return
        rows = rows_of(datagram)
        known, now_s = self.known, self._clock()
        before = known.words, known.damping_allowed
        known.take(rows, now_s)
        if len(self.pages):
            self._hand_on(rows)
        if (known.words, known.damping_allowed) != before:
            self.tell_status()

    def _hand_on(self, rows: list[Any]) -> None:
        for message in pack_rows(rows):
            self.pages.put(message)
        for row in rows:
            if row.loop_second is not None:
                self.pages.put(text("loop_second", row.loop_second))
            elif row.link is not None:
                self.pages.put(text("link", row.link))
            elif row.log is not None:
                self.pages.put(text("log", self.known.lines[-1]))

    def status(self) -> dict[str, Any]:
        """The status now."""
        return self._status(self.known, self._clock())

    def tell_status(self) -> None:
        """Send the status on change, and once a second. Call it ten times a second."""
        status, now_s = self.status(), self._clock()
        if status != self._sent or now_s >= self._due_s:
            self._sent, self._due_s = status, now_s + _STATUS_EVERY_S
            self.pages.put(text("status", status))


def text(kind: str, values: dict[str, Any]) -> str:
    """A message in JSON, {"type": kind, ...}; NaN becomes null."""
    return _ENCODE({"type": kind, **values}).decode()
