"""The effect of a bad network or an attacker on a datagram. Pure: bytes in, bytes with delays out."""

import random
from dataclasses import dataclass

from stillarm.common.datagrams.datagram import MAX_DATAGRAM_BYTES, TAG_BYTES, encode
from stillarm.common.datagrams.messages import MESSAGES

_WRONG_KEY = b"the key of someone who has none."
_REMEMBERED = 2000


@dataclass(frozen=True)
class LinkFault:
    """Probabilities for each datagram, and delays in seconds. All zero: a perfect link.

    reorder: probability of a delay by reorder_s; corrupt: of a changed bit; truncate, oversize: of a cut, of padding.
    replay: number of past datagrams sent along with each one; forge: number of forged datagrams.
    """

    drop: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    reorder_s: float = 0.02
    corrupt: float = 0.0
    truncate: float = 0.0
    oversize: float = 0.0
    replay: int = 0
    forge: int = 0


PERFECT = LinkFault()


def faulty_link(
    fault: LinkFault, data: bytes, past: list[bytes], rng: random.Random
) -> list[tuple[float, bytes]]:
    """The datagrams that arrive in place of `data`, each with its delay, s. past: earlier datagrams of the link."""
    arriving: list[tuple[float, bytes]] = []
    copies = 0 if rng.random() < fault.drop else 2 if rng.random() < fault.duplicate else 1
    for _ in range(copies):
        delay = fault.delay_s + (rng.uniform(0.0, fault.jitter_s) if fault.jitter_s else 0.0)
        if rng.random() < fault.reorder:
            delay += fault.reorder_s
        arriving.append((delay, _damaged(fault, data, rng)))
    for _ in range(fault.replay if past else 0):
        arriving.append((rng.uniform(0.0, 0.001), rng.choice(past)))
    for _ in range(fault.forge):
        arriving.append((rng.uniform(0.0, 0.001), forged(data, rng)))
    return arriving


def _damaged(fault: LinkFault, data: bytes, rng: random.Random) -> bytes:
    if rng.random() < fault.corrupt:
        changed = bytearray(data)
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
        data = bytes(changed)
    if rng.random() < fault.truncate:
        data = data[: rng.randrange(len(data))]
    if rng.random() < fault.oversize:
        data = data + bytes(rng.randrange(1, 2 * MAX_DATAGRAM_BYTES))
    return data


def forged(data: bytes, rng: random.Random) -> bytes:
    """A datagram that needs no key: noise, a true datagram with other contents, or one signed with another key."""
    how = rng.randrange(4)
    if how == 0:
        return rng.randbytes(rng.randrange(1, 200))
    if how == 1:
        message = rng.choice(MESSAGES)
        body = message(*[0.5] * len(message.__struct_fields__))
        return encode(_WRONG_KEY, rng.getrandbits(62) | 1, rng.randrange(1, 10**6), body)
    if how == 2 and len(data) > TAG_BYTES:
        return data[:-TAG_BYTES] + rng.randbytes(TAG_BYTES)
    changed = bytearray(data)
    for _ in range(rng.randrange(1, 9)):
        changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed) if bytes(changed) != data else b"\x00" + data


class Wire:
    """One direction of a link in virtual time: takes datagrams, and returns them when they arrive."""

    def __init__(self, seed: int) -> None:
        """A perfect link, until `fault` is set."""
        self.fault = PERFECT
        self.sent = 0
        self._rng = random.Random(seed)
        self._past: list[bytes] = []
        self._flying: list[tuple[float, int, bytes]] = []
        self._count = 0

    def send(self, data: bytes, now_s: float) -> None:
        """Put a datagram onto the wire."""
        self.sent += 1
        past = self._past
        if len(past) < _REMEMBERED:
            past.append(data)
        else:
            past[self._rng.randrange(_REMEMBERED)] = data
        perfect = self.fault is PERFECT
        arriving = [(0.0, data)] if perfect else faulty_link(self.fault, data, past, self._rng)
        for delay, arrived in arriving:
            self._count += 1
            self._flying.append((now_s + delay, self._count, arrived))

    def arrived(self, now_s: float) -> list[bytes]:
        """The datagrams that have arrived by a time, in order."""
        if not self._flying:
            return []
        here = sorted(entry for entry in self._flying if entry[0] <= now_s)
        if here:
            self._flying = [entry for entry in self._flying if entry[0] > now_s]
        return [data for _, _, data in here]
