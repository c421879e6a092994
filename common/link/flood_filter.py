"""Protection against a flood: when the kernel turns datagrams away, and the program for that.

In quiet times every datagram reaches the process, which counts it by what is wrong with it. In a flood that would cost
a system call and a tag each, so the kernel is given a classic BPF program (Linux: Documentation/networking/filter.rst)
that lets through only what has the length, version and kind of a datagram for this socket and echoes this process's
session, a random number that nobody off the path has seen, or echoes none, as a peer does that starts.
"""

import struct

from stillarm.common.datagrams.datagram import HEAD, MAX_DATAGRAM_BYTES, MIN_DATAGRAM_BYTES, kind_of
from stillarm.common.datagrams.messages import VERSION, Message

_UDP_HEADER_BYTES = 8  # what a program on a UDP socket sees begins with it
_LOAD_WORD, _LOAD_BYTE, _LOAD_LENGTH = 0x20, 0x30, 0x80  # BPF_LD + BPF_W, B, absolute
# BPF_JMP + JEQ, JGT, JGE with a constant
_IF_EQUAL, _IF_ABOVE, _IF_AT_LEAST, _RETURN = (0x15, 0x25, 0x35, 0x06)
_ALL = 0xFFFFFFFF
_UINT64 = 0xCF  # msgpack's mark; sessions are drawn so that they take it

Instruction = tuple[int, int, int, int]
"""code, jump if true, jump if false, constant"""


def flood_program(takes: tuple[type[Message], ...], session: int) -> list[Instruction]:
    """The program that lets through datagrams with the messages `takes` that echo `session` (2^32 or more) or none."""
    instructions: list[Instruction] = [
        (_LOAD_LENGTH, 0, 0, 0),
        (_IF_ABOVE, 0, 1, _UDP_HEADER_BYTES + MAX_DATAGRAM_BYTES),
        (_RETURN, 0, 0, 0),
        (_IF_AT_LEAST, 1, 0, _UDP_HEADER_BYTES + MIN_DATAGRAM_BYTES),
        (_RETURN, 0, 0, 0),
    ]
    for message in takes:
        instructions += _of_kind(message, session)
    return [*instructions, (_RETURN, 0, 0, 0)]


def _of_kind(message: type[Message], session: int) -> list[Instruction]:
    """Return if the datagram is of this kind: all of it if its echo is right, nothing if not. Else go on."""
    head = _array_head(len(HEAD) + len(message.__struct_fields__))
    at = _UDP_HEADER_BYTES
    wanted = [(at + i, byte) for i, byte in enumerate((*head, VERSION, kind_of(message)))]
    at += len(head) + 2
    echo = [
        (_LOAD_BYTE, 0, 0, at),  # the sender's session
        (_IF_EQUAL, 1, 0, _UINT64),
        (_RETURN, 0, 0, 0),
        (_LOAD_BYTE, 0, 0, at + 9),  # its echo
        (_IF_EQUAL, 0, 1, 0),
        (_RETURN, 0, 0, _ALL),
        (_IF_EQUAL, 1, 0, _UINT64),
        (_RETURN, 0, 0, 0),
        (_LOAD_WORD, 0, 0, at + 10),
        (_IF_EQUAL, 1, 0, session >> 32),
        (_RETURN, 0, 0, 0),
        (_LOAD_WORD, 0, 0, at + 14),
        (_IF_EQUAL, 0, 1, session & _ALL),
        (_RETURN, 0, 0, _ALL),
        (_RETURN, 0, 0, 0),
    ]
    instructions: list[Instruction] = []
    for index, (place, byte) in enumerate(wanted):
        left = 2 * (len(wanted) - index - 1) + len(echo)
        instructions += [(_LOAD_BYTE, 0, 0, place), (_IF_EQUAL, 0, left, byte)]
    return instructions + echo


def _array_head(fields: int) -> bytes:
    return bytes((0x90 | fields,)) if fields < 16 else b"\xdc" + struct.pack(">H", fields)


def packed(program: list[Instruction]) -> bytes:
    """The program as the kernel takes it: struct sock_filter, 8 bytes each."""
    return b"".join(struct.pack("=HBBI", *instruction) for instruction in program)


class FloodGuard:
    """Decides when to shield, from how many datagrams each look at a socket brings. Counts only, no clock."""

    _HEAT = 100
    _LOOKS = 1000
    _CALM = 500

    def __init__(self, expected_per_look: int) -> None:
        """expected_per_look: how many a peer that means well sends between two looks, at the most."""
        self._expected = expected_per_look
        self._heat = 0
        self._looks = 0
        self._shed_before = 0
        self.shielded = False

    def see(self, datagrams: int) -> bool:
        """One look brought so many datagrams; whether to look at once at what the kernel turned away, with judge()."""
        if self.shielded:
            self._looks += 1
            return self._looks >= self._LOOKS
        self._heat += datagrams - self._expected
        if self._heat <= 0:
            self._heat = 0
        elif self._heat > self._HEAT:
            return True
        return False

    def judge(self, shed: int) -> bool:
        """Whether to shield from now on; `shed`: the kernel's count of datagrams turned away so far."""
        if self.shielded:
            self.shielded = shed - self._shed_before > self._CALM
        else:
            self.shielded = True
        self._shed_before, self._looks, self._heat = shed, 0, 0
        return self.shielded
