"""The controller's side of the exchange with the supervisor (the paper's Fig. 2). Pure: bytes in, bytes out."""

from math import nan

import msgspec

from common.clock_offset import ClockOffset
from common.datagram import Kind, encode
from common.peer import LinkCounts, Peer
from common.visual_datagram import read_visual_body
from common.visual_sample import VisualSample


class ControllerExchange:
    """Sends the timestamp n_c at the start of a cycle, and takes visual data that echo this session's timestamps."""

    def __init__(self, key: bytes, session: int) -> None:
        """Sign with `key`; `session` is this process's own, never used before."""
        self._key = key
        self._session = session
        self._sequence = 0
        self._peer = Peer(key, (Kind.VISUAL,), session)
        self.clock = ClockOffset()
        """The supervisor's clock against this one's."""

    @property
    def counts(self) -> LinkCounts:
        """Counts of the visual datagrams since the start."""
        return self._peer.counts

    def count_by_name(self) -> dict[str, int]:
        """The same counts by name."""
        return {name: int(value) for name, value in msgspec.structs.asdict(self._peer.counts).items()}

    def expect(self, supervisor_session: int) -> None:
        """Know the supervisor's session from the start, as in virtual time."""
        self._peer.expect(supervisor_session)

    def timestamp(self, cycle: int, sent_s: float = nan) -> bytes:
        """The datagram that opens a cycle. sent_s: this clock's time, for the comparison of the clocks."""
        self._sequence += 1
        return encode(
            self._key, Kind.TIMESTAMP, self._session, self._sequence, (cycle, sent_s), echo=self._peer.echo
        )

    def take(self, datagrams: list[bytes], cycle: int, received_s: float = nan) -> list[VisualSample]:
        """The visual samples among the datagrams read in a cycle, in order. received_s: this clock's time.

        One that answers another session's timestamps, or one from the future, is counted as of an old session.
        """
        samples: list[VisualSample] = []
        for data in datagrams:
            sessions = self._peer.counts.sessions
            datagram = self._peer.receive(data)
            if datagram is None:
                continue
            if self._peer.counts.sessions != sessions:
                self.clock.reset()
            read = read_visual_body(datagram.body)
            if read is None:
                self._peer.counts.malformed += 1
            elif read[0] != self._session or not 0 <= read[1].started_cycle <= cycle:
                self._peer.counts.old_session += 1
            else:
                samples.append(read[1])
                self.clock.add(read[2], received_s)
        return samples


class ReferenceExchange:
    """Takes an operator's joint velocity reference; it lapses to zero when it is not renewed."""

    LAPSE_S = 0.1

    def __init__(self, key: bytes, session: int) -> None:
        """Accept references signed with `key` that echo `session`, this process's own."""
        self._key = key
        self._session = session
        self._sequence = 0
        self._peer = Peer(key, (Kind.REFERENCE,), session)
        self._velocity = 0.0
        self._damping = True
        self._time_s = float("-inf")

    @property
    def counts(self) -> LinkCounts:
        """Counts of the references since the start."""
        return self._peer.counts

    def hello(self) -> bytes | None:
        """What to answer to the sender of the last datagram taken: this session, where that did not know it yet."""
        if not self._peer.greeting:
            return None
        self._sequence += 1
        return encode(self._key, Kind.HELLO, self._session, self._sequence, (), echo=self._peer.greeting)

    def take(self, datagrams: list[bytes], time_s: float) -> None:
        """Read what has arrived by a time."""
        for data in datagrams:
            datagram = self._peer.receive(data)
            if datagram is None:
                continue
            velocity, damping = datagram.body
            if type(velocity) is float and type(damping) is bool and abs(velocity) < 1e6:
                self._velocity, self._damping, self._time_s = velocity, damping, time_s
            else:
                self._peer.counts.malformed += 1

    def reference(self, time_s: float) -> tuple[float, bool]:
        """Joint velocity reference, rad/s, and whether damping is allowed; zero and allowed when none is alive."""
        if time_s - self._time_s > self.LAPSE_S:
            return 0.0, True
        return self._velocity, self._damping
