"""For all tests: linear algebra uses one thread, as in the commands, and hypothesis times no example. The
run's last line says how many tests of measured data ran or were left out.
"""

from collections.abc import Sequence
from pathlib import Path

from stillarm.common.process.blas_threads import one_blas_thread

one_blas_thread()

import pytest  # noqa: E402 - nothing may load NumPy before
from hypothesis import settings  # noqa: E402

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

pytest_plugins = (
    "pytester",
    "tests.fixtures.cia402_bench",
    "tests.fixtures.emulated_ports",
    "tests.fixtures.lis3lv02dq",
    "tests.fixtures.register_chips",
    "tests.plugins.blind_slices",
    "tests.plugins.quick_tests",
)


@pytest.fixture(scope="session", autouse=True)
def _one_processor_each() -> None:
    """pytest has a worker for each processor: a diagnosis within a test makes no copies of it."""
    from stillarm.diagnosis.physics import copies

    copies.most_processes = 1


DATA = Path(__file__).parents[2] / "shared" / "data"
MARK = "hardware_data"

_deselected = pytest.StashKey[int]()


def pytest_deselected(items: Sequence[pytest.Item]) -> None:
    """Count those that another run of the same suite holds: its last line may be lost in this one's."""
    if items:
        stash = items[0].config.stash
        count = sum(item.get_closest_marker(MARK) is not None for item in items)
        stash[_deselected] = stash.get(_deselected, 0) + count


def measured_data_line(ran: int, skipped: int, deselected: int, there: bool) -> str:
    """The last line of a run; empty where no test of it needs measured data."""
    left_out = skipped + (0 if there else deselected)
    if left_out:
        why = "a part of ../shared/data is missing" if there else "../shared/data is not there"
        ran_too = f"{ran} run, " if ran else ""
        return f"measured data: {ran_too}{left_out} tests left out: {why}"
    return f"measured data: {ran} tests run, none left out" if ran else ""


def pytest_unconfigure(config: pytest.Config) -> None:
    """Say so after pytest's own last line."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or hasattr(config, "workerinput"):
        return

    def count(*outcomes: str, when: str) -> int:
        reports = [one for outcome in outcomes for one in reporter.stats.get(outcome, ())]
        return sum(MARK in getattr(one, "keywords", ()) and one.when == when for one in reports)

    ran = count("passed", "failed", when="call")
    skipped = count("skipped", when="setup") + count("skipped", when="call")
    line = measured_data_line(ran, skipped, config.stash.get(_deselected, 0), DATA.is_dir())
    if line:
        reporter.write_line(line)
