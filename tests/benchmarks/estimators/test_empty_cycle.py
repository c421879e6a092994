"""A cycle without an estimate."""

from stillarm.benchmarks.estimators.empty_cycle import empty_cycle_us


def test_an_empty_cycle_exchanges_its_datagrams() -> None:
    """Every one of them is taken; the cost is a positive number of microseconds."""
    cost = empty_cycle_us(200)
    assert 0.0 < cost["median"] <= 1e6
    assert cost["mean"] > 0.0
