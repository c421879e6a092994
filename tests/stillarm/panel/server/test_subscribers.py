"""The queue to a page: in order, bounded, and never waiting for who does not read."""

import asyncio

from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.server.subscribers import MOST_BYTES, MOST_QUEUED, Subscriber, Subscribers


@given(st.lists(st.integers(0, 200_000), max_size=200))
def test_what_is_kept_is_the_newest_in_order_and_bounded(sizes: list[int]) -> None:
    subscriber = Subscriber()
    messages = [number.to_bytes(2, "big") + bytes(size) for number, size in enumerate(sizes)]
    for message in messages:
        subscriber.put(message)
    kept = len(messages) - subscriber.dropped

    async def read() -> list[bytes | str]:
        return [await subscriber.get() for _ in range(kept)]

    assert asyncio.run(read()) == messages[len(messages) - kept :]
    assert kept <= MOST_QUEUED
    assert sum(len(m) for m in messages[len(messages) - kept :]) <= MOST_BYTES + 200_002


def test_a_reader_waits_for_the_next_message() -> None:
    async def run() -> bytes | str:
        subscriber = Subscriber()
        reading = asyncio.create_task(subscriber.get())
        await asyncio.sleep(0)
        subscriber.put("late")
        return await reading

    assert asyncio.run(run()) == "late"


def test_pages_beyond_the_most_are_refused_until_one_closes() -> None:
    pages = Subscribers(most=2)
    first, second = pages.add(), pages.add()
    assert first is not None and second is not None and pages.add() is None
    pages.remove(first)
    third = pages.add()
    assert third is not None and len(pages) == 2
    pages.put("to all")
    assert asyncio.run(second.get()) == asyncio.run(third.get()) == "to all"
