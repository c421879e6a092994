"""What was known when all was well is kept only once it has proven well, and compared in its own deviations."""

import numpy as np

from stillarm.controller.estimation.fused.recovery.remembered import Remembered


def state(value: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return np.full((2, 3), value), np.repeat(0.01 * np.eye(3)[None], 2, axis=0), np.array([0.0, -5.0])


def test_kept_after_it_has_proven_well() -> None:
    memory = Remembered()
    memory.calm(0.0, *state(1.0))
    assert memory.known is None
    memory.calm(1.0, *state(2.0))
    assert memory.known is None
    memory.calm(2.0, *state(3.0))
    assert memory.known is not None and memory.known.x[0, 0] == 1.0


def test_what_was_seen_just_before_trouble_is_not_trusted() -> None:
    memory = Remembered()
    for second in range(4):
        memory.calm(float(second), *state(float(second)))
    assert memory.known is not None
    then = memory.known.time_s
    memory.trouble()
    memory.calm(5.5, *state(9.0))
    memory.calm(5.6, *state(9.0))
    assert memory.known.time_s == then
    memory.forget()
    assert memory.known is None


def test_it_differs_by_more_than_four_of_its_own_deviations() -> None:
    memory = Remembered()
    assert not memory.differs(np.zeros(3), [1])
    for time_s in (0.0, 2.0):
        memory.calm(time_s, *state(1.0))
    assert not memory.differs(np.array([9.0, 1.39, 9.0]), [1])
    assert memory.differs(np.array([1.0, 1.41, 1.0]), [1])
