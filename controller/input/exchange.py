"""The controller's side of the exchange with the supervisor (the paper's Fig. 2). Pure: bytes in, bytes out."""

from math import nan

import msgspec

from stillarm.common.datagrams.datagram import LinkCounts, Peer, kind_of
from stillarm.common.datagrams.messages import (
    Adjustment,
    Hello,
    Message,
    OperatorCommand,
    Reference,
    Timestamp,
    Visual,
)
from stillarm.common.datagrams.visual_sample import LinkTimes, VisualSample
from stillarm.common.files.model import Model
from stillarm.common.link.clock_offset import ClockOffset

_HELD_UP_S = 0.1


def oldest_sample_s(model: Model, cycles_in_flight: int) -> float:
    """How old n_i can be when visual data are read, s: images asked for ahead, the longest capture delay, and 0.1 s."""
    timing = model.timing
    delay = timing.capture_delay_s + 4.0 * timing.capture_delay_std_s
    return delay + cycles_in_flight / model.camera.frame_rate_hz + _HELD_UP_S


class ControllerExchange:
    """Sends the timestamp n_c at the start of a cycle, and takes visual data that echo this session's timestamps."""

    def __init__(self, key: bytes, session: int, oldest_cycles: int = 1 << 62) -> None:
        """Sign with `key`; `session` is this process's own, never used before.

        oldest_cycles: how long ago the supervisor may have begun what it sends: oldest_sample_s().
        """
        self._oldest_cycles = oldest_cycles
        self._session = session
        self._peer = Peer(key, (Visual,), session)
        self._restarted = False
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
        return self._peer.encode(Timestamp(cycle, sent_s))

    def take(self, datagrams: list[bytes], cycle: int, received_s: float = nan) -> list[VisualSample]:
        """The visual samples among the datagrams read in a cycle, in order. received_s: this clock's time.

        One that answers another session's timestamps, or one from the future, is counted as of an old session; one
        that was held up on its way, as overdue: no estimator looks for a delay so long, and it is no ground to damp on.
        """
        samples: list[VisualSample] = []
        for data in datagrams:
            sessions = self._peer.counts.sessions
            datagram = self._peer.receive(data)
            if datagram is None:
                continue
            if self._peer.counts.sessions != sessions:
                self.clock.reset()
                self._restarted = sessions > 0
            visual = datagram.body
            if visual.timestamp_session != self._session or not 0 <= visual.started_cycle <= cycle:
                self._peer.counts.old_session += 1
            elif cycle - visual.started_cycle > self._oldest_cycles:
                self._peer.counts.overdue += 1
            else:
                samples.append(self._marked(visual_sample(visual)))
                self.clock.add(LinkTimes(visual.sent_s, visual.received_s, visual.answered_s), received_s)
        return samples

    def _marked(self, sample: VisualSample) -> VisualSample:
        """The sample; marked where it is the first one of a supervisor that was started anew."""
        if not self._restarted:
            return sample
        self._restarted = False
        return msgspec.structs.replace(sample, restarted=True)


def visual_sample(message: Visual) -> VisualSample:
    """The sample in a message."""
    return msgspec.convert(message, VisualSample, from_attributes=True)


class ReferenceExchange:
    """Takes an operator's joint velocity reference; it lapses to zero when it is not renewed."""

    LAPSE_S = 0.1

    def __init__(self, key: bytes, session: int) -> None:
        """Accept references signed with `key` that echo `session`, this process's own."""
        self._peer = Peer(key, (Reference,), session)
        self._operator = Peer(key, (OperatorCommand, Adjustment), session)
        self._asked = 0
        self._adjustment: Adjustment | None = None
        self._velocity = 0.0
        self._damping = True
        self._time_s = float("-inf")

    @property
    def counts(self) -> LinkCounts:
        """Counts of the references since the start."""
        return self._peer.counts

    def hello(self) -> bytes | None:
        """What to answer to the sender of the last datagram taken: this session, where that did not know it yet."""
        greeting = self._peer.greeting or self._operator.greeting
        return self._peer.encode(Hello(), echo=greeting) if greeting else None

    def take(self, datagrams: list[bytes], time_s: float) -> None:
        """Read what has arrived by a time."""
        for data in datagrams:
            self._peer.greeting = self._operator.greeting = 0
            if data[_KIND_AT : _KIND_AT + 1] in _OPERATOR:
                command = self._operator.receive(data)
                if command is not None:
                    self._see_operator(command.body)
            elif (datagram := self._peer.receive(data)) is not None:
                reference = datagram.body
                self._velocity, self._damping = reference.velocity_rad_s, reference.damping_allowed
                self._time_s = time_s

    def asked(self) -> int:
        """What the operator has asked for since the last call, bits of stillarm.controller.safety.table.Operator."""
        asked, self._asked = self._asked, 0
        return asked

    def _see_operator(self, body: Message) -> None:
        if isinstance(body, Adjustment):
            self._adjustment = body
        elif isinstance(body, OperatorCommand):
            self._asked |= body.bits

    def adjustment(self) -> Adjustment | None:
        """The newest adjustment that the operator has asked for since the last call."""
        asked, self._adjustment = self._adjustment, None
        return asked

    def reference(self, time_s: float) -> tuple[float, bool]:
        """Joint velocity reference, rad/s, and whether damping is allowed; zero and allowed when none is alive."""
        if time_s - self._time_s > self.LAPSE_S:
            return 0.0, True
        return self._velocity, self._damping


_KIND_AT = 2  # after the array's head and the version, a byte each
_OPERATOR = frozenset(bytes((kind_of(message),)) for message in (OperatorCommand, Adjustment))
