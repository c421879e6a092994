"""One end of a link: which datagrams of the peer to take, the counts of those not taken, and what to send it.

A session proves itself by echoing this side's own, which is random and drawn anew at each start: whoever can
do that, and sign it, has heard from this very process. So nothing that was recorded before this process
started is ever taken, and of what was recorded since, nothing but what is newer than the newest.
"""

from typing import Any, Generic, TypeVar

import msgspec

from stillarm.common.datagrams.datagram import Datagram, Rejected, decode, encode
from stillarm.common.datagrams.messages import Message

_Taken = TypeVar("_Taken", bound=Message)


class LinkCounts(msgspec.Struct):
    """Counts since the start. `lost` is the net number of sequence numbers never seen.

    unproven: well signed, but without an echo of this side's session: from a peer that does not know it yet, or
    played back. unexpected: well-formed, but of a kind that this socket does not take. overdue: what it says
    is from too long ago.
    """

    accepted: int = 0
    lost: int = 0
    duplicate: int = 0
    late: int = 0
    malformed: int = 0
    forged: int = 0
    foreign_version: int = 0
    old_session: int = 0
    unexpected: int = 0
    sessions: int = 0
    unproven: int = 0
    overdue: int = 0

    @property
    def refused(self) -> int:
        """Datagrams that were not taken for any reason but their order."""
        return (
            self.malformed
            + self.forged
            + self.foreign_version
            + self.old_session
            + self.unexpected
            + self.unproven
        )


class Peer(Generic[_Taken]):
    """Accepts the datagrams of one peer, in order, across its restarts, and packs those for it. Pure: no socket.

    A session that has been replaced is never accepted again. State moves on only after the tag holds.
    """

    MOST_SESSIONS = 4096
    """A peer that restarted more often is refused until this side restarts too: what is remembered stays
    bounded."""
    _REORDER_WINDOW = 256  # how far back a late datagram can be told from a duplicate

    def __init__(self, key: bytes, takes: tuple[type[_Taken], ...], own_session: int = 0) -> None:
        """Take the messages `takes` signed with `key`.

        own_session: that of this side, which a peer must echo; 0 asks for no proof (of what can do no harm).
        """
        self._key = key
        self._takes = takes
        self._own = own_session
        self._sent = 0
        self.session = 0
        self.sequence = 0
        self._heard = 0
        self._seen = 0  # bit k: sequence - k has been seen
        self._old: set[int] = set()
        self.greeting = 0
        """Session of the last datagram if that was well signed but proved nothing, else 0: it can be answered."""
        self.counts = LinkCounts()

    @property
    def echo(self) -> int:
        """What to echo: the session that is taken; until there is one, that last heard of; 0 before that."""
        return self.session or self._heard

    def expect(self, session: int) -> None:
        """Echo `session` from the start, where it is known before anything was heard."""
        self._heard = session

    def encode(self, body: Message, *, echo: int | None = None) -> bytes:
        """The next datagram of this side's session; echo: None for the peer's."""
        self._sent += 1
        return encode(self._key, self._own, self._sent, body, echo=self.echo if echo is None else echo)

    def receive(self, data: bytes) -> Datagram[_Taken] | None:  # noqa: PLR0911 - one for each check, in order
        """The datagram if it is the newest so far of its session; None otherwise, and counted."""
        counts = self.counts
        self.greeting = 0
        datagram: Datagram[Any] | Rejected = decode(self._key, data)
        if isinstance(datagram, Rejected):
            setattr(counts, datagram.reason, getattr(counts, datagram.reason) + 1)
            return None
        if not isinstance(datagram.body, self._takes):
            counts.unexpected += 1
            return None
        if self._own and (datagram.echo != self._own or datagram.session == self._own):
            counts.unproven += 1
            if datagram.session == self._own:  # sent back to its sender
                return None
            self.greeting = self._heard = datagram.session
            return None
        if datagram.session != self.session:
            if datagram.session in self._old or len(self._old) >= self.MOST_SESSIONS:
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

    def _begin(self, datagram: Datagram[_Taken]) -> None:
        if self.session:
            self._old.add(self.session)
        self.session = datagram.session
        self.sequence = datagram.sequence
        self._seen = (1 << self._REORDER_WINDOW) - 1  # what came before the first one seen is not missed
        self.counts.sessions += 1
        self.counts.accepted += 1
