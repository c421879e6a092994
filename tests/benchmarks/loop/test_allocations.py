"""Allocations are counted exactly, and only while they are to be."""

import sys

import pytest

from stillarm.benchmarks.loop.allocations import AllocationCounter


@pytest.fixture(scope="module")
def counter() -> AllocationCounter:
    pytest.importorskip("llvmlite")
    return AllocationCounter()


def rise(counter: AllocationCounter, make: object) -> int:
    """Calls of the allocators while make() runs, less those that reading the count itself takes."""
    assert callable(make)
    before = counter.count()
    made = make()
    after = counter.count()
    nothing = counter.count() - after
    del made
    return after - before - nothing


def test_each_object_is_counted_once(counter: AllocationCounter) -> None:
    """Objects without a free list, in a list that has its room already: one allocation each."""
    room: list[object] = [None] * 64

    def fill(count: int) -> None:
        for place in range(count):
            room[place] = object()

    with counter.counting():
        few, many = rise(counter, lambda: fill(4)), rise(counter, lambda: fill(64))
    assert many - few == 60


def test_what_is_reused_is_not_counted(counter: AllocationCounter) -> None:
    """A sum of floats lives on the interpreter's free list."""

    def add(count: int) -> None:
        total = 0.5
        for _ in range(count):
            total = total * 1.5 - 1.0

    with counter.counting():
        few, many = rise(counter, lambda: add(10)), rise(counter, lambda: add(200))
    assert many - few <= 2


def test_nothing_is_counted_afterwards(counter: AllocationCounter) -> None:
    with counter.counting():
        pass
    before = counter.count()
    made = [object() for _ in range(sys.getrecursionlimit())]
    assert counter.count() == before
    del made
