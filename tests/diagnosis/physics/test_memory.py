"""Few worlds remember at once."""

import gc
from weakref import ref

from stillarm.diagnosis.physics.memory import give_back, remembers


class _World:
    def __init__(self) -> None:
        self.forgot = False

    def forget(self) -> None:
        self.forgot = True


def test_of_more_than_a_few_the_one_that_was_noted_longest_ago_forgets() -> None:
    worlds = [_World() for _ in range(5)]
    for one in [*worlds[:4], worlds[0], worlds[0]]:
        remembers(one)
    assert not any(one.forgot for one in worlds)
    remembers(worlds[4])
    assert [one.forgot for one in worlds] == [False, True, False, False, False]


def test_what_is_noted_is_not_kept() -> None:
    world = _World()
    remembers(world)
    gone = ref(world)
    del world
    gc.collect()
    assert gone() is None


def test_memory_is_given_back_without_a_word_on_any_system() -> None:
    give_back()
