"""Words shared between processes are read whole: a reader never sees half of a store, nor a zero in between."""

import multiprocessing
import struct
import time

import pytest

from stillarm.common.memory.shared_memory import SharedRing

_PAIR = struct.Struct("<QQ")
_SPAN_S = 0.7


def _drain_ring(name: str, messages: int) -> None:
    ring = SharedRing(name, create=False)
    wanted = 0
    while wanted < messages:
        message = ring.get()
        if message is not None:
            if message != _message(wanted):
                raise SystemExit(1)
            wanted += 1
    ring.close()


def _message(number: int) -> bytes:
    return number.to_bytes(8, "little") * (1 + number % 9)


@pytest.mark.slow
def test_a_ring_hands_over_every_message_once_and_in_order() -> None:
    """Through many wraps of a ring that is never full, no put may fail for want of room."""
    name, messages, size = "test-torn-ring", 60_000, 1 << 16
    ring = SharedRing(name, size, create=True)
    words = ring.block.header.cast("Q")
    reader = multiprocessing.get_context("spawn").Process(target=_drain_ring, args=(name, messages))
    reader.start()
    for number in range(messages):
        while words[1] - words[2] > size // 2 and reader.is_alive():
            time.sleep(0.0)
        ring.put(_message(number))
    reader.join(30.0)
    words.release()
    lost = ring.lost
    ring.close()
    assert lost == 0
    assert reader.exitcode == 0
