"""What is counted as which section."""

from collections.abc import Callable

from stillarm.benchmarks.loop.sections import MarkedDevices, MarkedMethod, Section, SectionMeter
from stillarm.controller.input.cycle_input import CycleInput


class Counter:
    """A reading that goes up by what is spent."""

    def __init__(self) -> None:
        self.value = 0

    def spend(self, amount: int) -> None:
        self.value += amount

    def read(self) -> int:
        """Its own cost must not be counted."""
        self.value += 1000
        return self.value - 1000


class Devices:
    def __init__(self, spend: Callable[[int], None]) -> None:
        self.spend = spend

    def sense(self, cycle: int) -> tuple[float, float, float, float]:
        self.spend(1)
        return 0.0, 0.0, 0.0, 0.0

    def receive(self, cycle: int, sensed: tuple[float, float, float, float]) -> CycleInput:
        self.spend(2)
        return CycleInput(cycle, sensed[0])

    def write(self, command_rad_s: float) -> None:
        self.spend(16)


class Method:
    def __init__(self, spend: Callable[[int], None]) -> None:
        self.spend = spend

    def update(self, observation: object) -> str:
        self.spend(4)
        return "estimate"


def test_each_section_gets_what_was_spent_in_it() -> None:
    """The marks' own readings, a thousand each, are in no section."""
    counter = Counter()
    meter = SectionMeter(counter.read)
    devices = MarkedDevices(Devices(counter.spend), meter)  # type: ignore[arg-type]
    method = MarkedMethod(Method(counter.spend), meter)  # type: ignore[arg-type]
    for cycle in range(2):
        assert devices.read(cycle).cycle == cycle
        counter.spend(3)
        assert method.update(None) == "estimate"  # type: ignore[arg-type, comparison-overlap]
        counter.spend(5)
        devices.write(0.0)
        counter.spend(32)
        meter.end(Section.RECORD)
        counter.spend(10_000)  # the rig
        meter.begin()
        counter.spend(64)
        meter.end(Section.SLEEP)
        meter.end_cycle()
        counter.spend(77)
    wanted = {
        Section.SENSE: 1,
        Section.RECEIVE: 2,
        Section.ESTIMATE: 4,
        Section.DECIDE: 8,
        Section.COMMAND: 16,
        Section.RECORD: 32,
        Section.SLEEP: 64,
    }
    assert meter.rows == [[wanted[section] for section in Section]] * 2
