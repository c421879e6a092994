"""Which stamps count."""

from stillarm.drivers.cameras.camera_stamps import StampGate


def test_stamps_must_be_recent_monotonic_and_rising():
    gate = StampGate()
    assert gate.accept(99.98, 100.0) == 99.98
    assert gate.accept(99.98, 100.01) is None  # the same again
    assert gate.accept(100.5, 100.02) is None  # the future
    assert gate.accept(50.0, 100.03) is None  # a play time, or another clock
    assert gate.accept(float("nan"), 100.03) is None
    assert gate.accept(100.01, 100.03) == 100.01
