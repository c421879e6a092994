"""The supervisor's side of the exchange with the controller (the paper's Fig. 2). Pure: bytes in, bytes out."""

from collections import deque
from math import nan
from typing import NamedTuple

from common.datagram import Kind, encode
from common.peer import LinkCounts, Peer
from common.visual_datagram import LinkTimes, visual_body
from common.visual_sample import VisualSample


class Timestamp(NamedTuple):
    """The latest timestamp of the controller: its session and its cycle n_c; session 0 before the first."""

    session: int
    cycle: int


class SupervisorExchange:
    """Keeps only the latest timestamp, and answers with visual data that carry the timestamp at the cycle's start.

    A cycle begins when an image is requested and ends when its data are sent. With several buffers queued at the
    camera, `cycles_in_flight` cycles overlap. Images arrive in the order of their requests.
    """

    def __init__(self, key: bytes, session: int, cycles_in_flight: int) -> None:
        """key: signs all datagrams. session: a number of this process that was never used before."""
        self._key = key
        self._session = session
        self._sequence = 0
        self._in_flight = cycles_in_flight
        self._begun: deque[Timestamp] = deque()
        self._peer = Peer(key, (Kind.TIMESTAMP,), session)
        self._sent_s = self._received_s = nan  # of the latest timestamp
        self.latest = Timestamp(0, -1)

    @property
    def counts(self) -> LinkCounts:
        """Counts of the timestamps since the start."""
        return self._peer.counts

    def take(self, datagrams: list[bytes], received_s: float = nan) -> None:
        """Read the datagrams that have arrived and keep the latest timestamp. received_s: this clock's time."""
        for data in datagrams:
            datagram = self._peer.receive(data)
            if datagram is None:
                continue
            cycle, sent_s = datagram.body
            if type(cycle) is int and cycle >= 0 and type(sent_s) is float:
                self.latest = Timestamp(datagram.session, cycle)
                self._sent_s, self._received_s = sent_s, received_s
            else:
                self._peer.counts.malformed += 1

    def begin_cycles(self) -> int:
        """Begin as many cycles as may be in flight, with the latest timestamp as n_i. Returns their number."""
        new = self._in_flight - len(self._begun)
        self._begun.extend([self.latest] * new)
        return new

    def oldest(self) -> Timestamp:
        """The timestamp at the start of the oldest cycle in flight, whose image arrives next."""
        return self._begun[0]

    def end_cycle(self, sample: VisualSample, answered_s: float = nan) -> bytes:
        """End the oldest cycle. Returns the datagram with its visual data and n_i. answered_s: this clock's time."""
        started = self._begun.popleft()
        self._sequence += 1
        body = visual_body(started.session, sample, LinkTimes(self._sent_s, self._received_s, answered_s))
        return encode(self._key, Kind.VISUAL, self._session, self._sequence, body, echo=self._peer.echo)
