"""The header stands first."""

from tests.fixtures.recordings import some_fast, written


def test_the_header_stands_before_the_messages() -> None:
    data = written(some_fast(10))
    assert 0 < data.index(b"length_m = 2.0") < 2000
