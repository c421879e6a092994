"""How simulations are computed."""

import pytest

from stillarm.diagnosis.physics.computing import Lately, OutOfTime, check_time, limited, limited_to


def test_the_last_few_results_are_remembered() -> None:
    done: list[int] = []

    def square(x: int) -> int:
        done.append(x)
        return x * x

    lately: Lately[int, int] = Lately(2)
    assert [lately.of(x, lambda x=x: square(x)) for x in (1, 2, 1, 2)] == [1, 4, 1, 4]
    assert done == [1, 2]
    lately.of(3, lambda: square(3))
    lately.of(2, lambda: square(2))
    assert done == [1, 2, 3]
    lately.of(1, lambda: square(1))
    assert done == [1, 2, 3, 1]
    lately.forget()
    lately.of(1, lambda: square(1))
    assert done == [1, 2, 3, 1, 1]


def test_a_share_of_the_time_is_of_what_is_left() -> None:
    now_s = [2.0]
    with limited(10.0, lambda: now_s[0]):
        with limited_to(0.5):
            now_s[0] = 5.9
            check_time()
            now_s[0] = 6.1
            with pytest.raises(OutOfTime):
                check_time()
        check_time()


def test_a_share_of_unlimited_time_is_unlimited() -> None:
    with limited_to(0.0):
        check_time()
