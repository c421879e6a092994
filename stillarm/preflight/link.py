"""Checks the link: key, ports, and the round trip to a running supervisor or through this computer's own sockets."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import isnan

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Configuration, Link
from stillarm.common.link.link_key import is_loopback, load_key
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError
from stillarm.controller.input.exchange import ControllerExchange
from stillarm.preflight.verdict import Verdict, fail, ok, warn
from stillarm.supervisor.exchange import SupervisorExchange

_LONG_ROUND_TRIP_S = 0.005
_AT_ONCE = 64
_OWN_ROUNDS = 50


@dataclass(frozen=True)
class LinkFacts:
    """What was observed of the link.

    answered: accepted visual data; forged: datagrams refused for their signature; round_trip_s: NaN if unknown;
    of_a_supervisor: False if no supervisor runs here and this computer answered itself.
    """

    answered: int
    forged: int
    round_trip_s: float
    of_a_supervisor: bool
    samples: tuple[tuple[float, VisualSample], ...] = ()


def port_is_free(host: str, port: int) -> bool:
    """Whether nobody listens on the port. Also True for a host that is another computer."""
    try:
        UdpSocket((host, port), "").close()
    except UserError as error:
        return "in use" not in str(error)
    return True


def is_here(host: str) -> bool:
    """Whether a host is this computer."""
    if is_loopback(host):
        return True
    try:
        UdpSocket((host, 0), "").close()
    except UserError:
        return False
    return True


def judge_key(link: Link) -> tuple[bytes | None, Verdict]:
    """The key, or None if it may not be used, and the verdict."""
    try:
        key = load_key(link)
    except UserError as error:
        return None, fail("link", str(error))
    if key == DEMO_KEY:
        return key, warn(
            "link",
            "link.key_file is empty: the demo key is public; use it on this computer only",
        )
    return key, ok("link", f"key from {link.key_file}")


def ask_supervisor(
    configuration: Configuration,
    key: bytes,
    span_s: float,
    cycle_s: float,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> LinkFacts:
    """Act as a controller for a while: send timestamps, receive visual data. Raises UserError if the port is in use."""
    link = configuration.link
    exchange = ControllerExchange(key, new_session())
    socket = UdpSocket((link.controller_host, link.controller_port), "link.controller_port")
    samples: list[tuple[float, VisualSample]] = []
    try:
        begun, cycle = clock(), 0
        while clock() < begun + span_s:
            socket.send(exchange.timestamp(cycle, clock()), (link.supervisor_host, link.supervisor_port))
            for sample in exchange.take(socket.drain(_AT_ONCE), cycle, clock()):
                samples.append((clock(), sample))
            cycle += 1
            sleep(max(0.0, begun + cycle * cycle_s - clock()))
    finally:
        socket.close()
    counts, estimate = exchange.counts, exchange.clock.estimate
    return LinkFacts(counts.accepted, counts.forged, estimate.round_trip_s, True, tuple(samples))


def ask_itself(configuration: Configuration, key: bytes) -> LinkFacts:
    """Send timestamps from one port to the other and answer them. Raises UserError if a port is in use."""
    link = configuration.link
    controller = ControllerExchange(key, new_session())
    supervisor = SupervisorExchange(key, new_session(), 1)
    ours = UdpSocket((link.controller_host, link.controller_port), "link.controller_port")
    try:
        theirs = UdpSocket((link.supervisor_host, link.supervisor_port), "link.supervisor_port")
    except UserError:
        ours.close()
        raise
    shortest = float("nan")
    try:
        for cycle in range(_OWN_ROUNDS):
            sent = time.monotonic()
            ours.send(controller.timestamp(cycle, sent), theirs.address)
            supervisor.take(_arrived(theirs), time.monotonic())
            supervisor.begin_cycles()
            answer = supervisor.end_cycle(VisualSample(cycle, supervisor.oldest().cycle, 1), time.monotonic())
            theirs.send(answer, ours.address)
            controller.take(_arrived(ours), cycle, time.monotonic())
            passed = time.monotonic() - sent
            shortest = passed if isnan(shortest) else min(shortest, passed)
    finally:
        ours.close()
        theirs.close()
    counts = controller.counts
    return LinkFacts(counts.accepted, counts.forged, shortest, False)


def _arrived(socket: UdpSocket) -> list[bytes]:
    until = time.monotonic() + 0.1
    while not (data := socket.drain(_AT_ONCE)) and time.monotonic() < until:
        time.sleep(0.0001)
    return data


def judge_link(facts: LinkFacts, link: Link) -> Verdict:
    """Whether there is a timely answer, signed with the same key."""
    place = f"{link.supervisor_host}:{link.supervisor_port}"
    if facts.forged and not facts.answered:
        return fail(
            "link",
            f"{facts.forged} datagrams from {place} carry another signature: the keys differ; copy one "
            "link.key_file to both computers",
        )
    if not facts.answered:
        return fail(
            "link",
            f"no supervisor answers at {place}: start it there (`stillarm supervisor`), correct "
            "link.supervisor_host and supervisor_port, open UDP in the firewall, and give both computers the same key",
        )
    if facts.round_trip_s > _LONG_ROUND_TRIP_S:
        return warn(
            "link",
            f"round trip to {place} {1e3 * facts.round_trip_s:.1f} ms; use a direct cable or a switch without sleep",
        )
    trip = "" if isnan(facts.round_trip_s) else f", round trip {1e3 * facts.round_trip_s:.2f} ms"
    who = "the supervisor answers" if facts.of_a_supervisor else "no supervisor runs; the ports are free"
    return ok("link", f"{who} ({place}{trip})")
