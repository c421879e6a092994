"""Words shared between processes are read whole: a reader never sees half of a store, nor a zero in between."""

import multiprocessing
import struct
import time

from common.shared_memory import SharedRecord, SharedRing

_PAIR = struct.Struct("<QQ")
_SPAN_S = 0.7


def _write_records(name: str) -> None:
    record = SharedRecord(name, _PAIR, create=False)
    number, end = 1 << 40, time.monotonic() + _SPAN_S
    while time.monotonic() < end:
        number += 1
        record.write(number, number)
    record.close()


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


def test_a_record_is_never_read_torn() -> None:
    """A writer at full speed: every value read is one that was written, and they never go back."""
    name = "test-torn-record"
    record = SharedRecord(name, _PAIR, create=True)
    writer = multiprocessing.get_context("spawn").Process(target=_write_records, args=(name,))
    writer.start()
    last = reads = 0
    while writer.is_alive():
        for _ in range(500):
            values = record.read(attempts=10_000_000)  # patient: the writer may be interrupted in the middle
            if values is None:
                assert last == 0, "a record that was written is not there"
                continue
            first, second = values
            assert first == second
            assert isinstance(first, int) and first >= last
            last, reads = first, reads + 1
    record.close()
    assert writer.exitcode == 0
    assert reads > 1000


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
