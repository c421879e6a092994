"""Which datagrams of a peer to take: newest session, increasing sequence; and the counts of those
not taken.
"""

from collections import deque

import msgspec

from common.datagram import Datagram, Rejected, decode


class LinkCounts(msgspec.Struct):
    """Counts since the start. `lost` is the net number of sequence numbers never seen."""

    accepted: int = 0
    lost: int = 0
    duplicate: int = 0
    late: int = 0
    malformed: int = 0
    forged: int = 0
    foreign_version: int = 0
    old_session: int = 0
    unexpected: int = 0  # well-formed, but of a kind that this socket does not take
    sessions: int = 0


class Peer:
    """Accepts the datagrams of one peer, in order, across its restarts. Pure: bytes in, datagrams out.

    A session that has been replaced is never accepted again, so that an old one cannot be replayed. State
    moves on only after the tag holds.
    """

    _REMEMBERED_SESSIONS = 64
    _REORDER_WINDOW = 256  # how far back a late datagram can be told from a duplicate

    def __init__(self, key: bytes, kinds: tuple[int, ...]) -> None:
        """Take datagrams of `kinds` signed with `key`."""
        self._key = key
        self._kinds = kinds
        self.session = 0
        self.sequence = 0
        self._seen = 0  # bit k: sequence - k has been seen
        self._old: deque[int] = deque(maxlen=self._REMEMBERED_SESSIONS)
        self.counts = LinkCounts()

    def receive(self, data: bytes) -> Datagram | None:
        """The datagram if it is the newest so far of its session; None otherwise, and counted."""
        counts = self.counts
        datagram = decode(self._key, data)
        if isinstance(datagram, Rejected):
            setattr(counts, datagram.reason, getattr(counts, datagram.reason) + 1)
            return None
        if datagram.kind not in self._kinds:
            counts.unexpected += 1
            return None
        if datagram.session != self.session:
            if datagram.session in self._old:
                counts.old_session += 1
                return None
            self._begin(datagram)
            return datagram
        step = datagram.sequence - self.sequence
        if step > 0:
            counts.accepted += 1
            counts.lost += step - 1
            self.sequence = datagram.sequence
            self._seen = ((self._seen << min(step, self._REORDER_WINDOW)) | 1) & (
                (1 << self._REORDER_WINDOW) - 1
            )
            return datagram
        behind = -step
        if behind < self._REORDER_WINDOW and not self._seen >> behind & 1:
            self._seen |= 1 << behind
            counts.late += 1
            counts.lost -= 1
        else:
            counts.duplicate += 1
        return None

    def _begin(self, datagram: Datagram) -> None:
        if self.session:
            self._old.append(self.session)
        self.session = datagram.session
        self.sequence = datagram.sequence
        self._seen = (1 << self._REORDER_WINDOW) - 1  # what came before the first one seen is not missed
        self.counts.sessions += 1
        self.counts.accepted += 1
