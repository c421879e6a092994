"""How simulations are computed."""

from stillarm.diagnosis.physics.computing import Lately


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
