"""The passes of the cycle's sections, with the loop's own code."""

from collections.abc import Iterator

import pytest

from stillarm.benchmarks.loop.allocations import countable
from stillarm.benchmarks.loop.cycle_budget import CycleBudget, SectionFigures
from stillarm.benchmarks.loop.sections import Section

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def figures() -> Iterator[dict[Section, SectionFigures]]:
    budget = CycleBudget()
    try:
        yield budget.measure(0.3)
    finally:
        budget.close()


def test_the_step_does_its_work(figures: dict[Section, SectionFigures]) -> None:
    """The estimate takes most calls: the vibration is seen, and damped. How long anything takes is not judged."""
    calls = {section: row.calls for section, row in figures.items()}
    assert max(calls, key=lambda section: calls[section]) is Section.ESTIMATE
    assert all(row.us[0] <= row.us[1] for row in figures.values())
    assert all(row.calls > 1.0 for row in figures.values())


def test_what_is_sent_and_read_has_a_floor(figures: dict[Section, SectionFigures]) -> None:
    with_floor = {section for section, row in figures.items() if row.floor_us is not None}
    assert with_floor == {Section.SENSE, Section.COMMAND, Section.SLEEP}


def test_calls_and_allocations_repeat(figures: dict[Section, SectionFigures]) -> None:
    """They are counts of the program, not of the machine: another pass gives nearly the same."""
    budget = CycleBudget()
    try:
        again = budget.measure(0.3)
    finally:
        budget.close()
    for section in (Section.SENSE, Section.ESTIMATE, Section.DECIDE, Section.COMMAND):
        assert again[section].calls == pytest.approx(figures[section].calls, rel=0.1)
        if countable():
            allocations = figures[section].allocations
            assert allocations is not None and allocations > 0.0
            assert again[section].allocations == pytest.approx(allocations, rel=0.1)
