"""Meters the sections of a cycle in the loop's own code: it is given devices, a method and a clock that mark them.

The loop and the step do not know of it, so that it costs them nothing where it is not in use.
"""

import time
from collections.abc import Callable
from enum import IntEnum

from stillarm.benchmarks.loop.loopback_rig import LoopbackRig
from stillarm.controller.estimation.estimate import Estimate, Method, Observation
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.live_devices import LiveDevices
from stillarm.controller.loop.schedule import CycleClock

_TRIES = 20


class Section(IntEnum):
    """A cycle's sections, in order. DECIDE is what the step does before and after it asks the method."""

    SENSE = 0  # the timestamp sent, accelerometer and drive read
    RECEIVE = 1  # images, references and the operator's requests
    ESTIMATE = 2  # the method
    DECIDE = 3  # checks of the input, the joint's model, permission, damping, limits
    COMMAND = 4  # the command sent
    RECORD = 5  # counters, and the messages into the recorder's ring
    SLEEP = 6  # until the next cycle; its duration is by how much it is too long


class SectionMeter:
    """Sums up by section what a reading rises by: nanoseconds, calls or allocations."""

    def __init__(self, reading: Callable[[], int]) -> None:
        """reading: the count so far."""
        self._reading = reading
        self._since = 0
        self._own = min(-reading() + reading() for _ in range(_TRIES))  # what a reading itself counts for
        self._row = [0] * len(Section)
        self.rows: list[list[int]] = []
        """What each section of each cycle took, in the order of Section."""

    def begin(self) -> None:
        """A section begins now."""
        self._since = self._reading()

    def end(self, section: Section) -> None:
        """The section that began at the last mark ends now, and the next one begins."""
        self._row[section] += self._reading() - self._since - self._own
        self._since = self._reading()  # so that the sum above is part of no section

    def end_cycle(self) -> None:
        """All sections of a cycle have ended."""
        self.rows.append(self._row)
        self._row = [0] * len(Section)


class MarkedDevices:
    """The controller's devices; implements stillarm.controller.loop.loop.Devices."""

    def __init__(self, devices: LiveDevices, meter: SectionMeter) -> None:
        """Mark the sections of `devices`, which are open."""
        self._devices, self._meter = devices, meter

    def read(self, cycle: int) -> CycleInput:
        """As LiveDevices.read."""
        meter, devices = self._meter, self._devices
        meter.begin()
        sensed = devices.sense(cycle)
        meter.end(Section.SENSE)
        read = devices.receive(cycle, sensed)
        meter.end(Section.RECEIVE)
        return read

    def write(self, command_rad_s: float) -> None:
        """As LiveDevices.write."""
        meter = self._meter
        meter.end(Section.DECIDE)
        self._devices.write(command_rad_s)
        meter.end(Section.COMMAND)

    @property
    def link_counts(self) -> dict[str, int]:
        """Counts of the visual datagrams, by name."""
        return self._devices.link_counts

    def link_status(self) -> dict[str, float]:
        """The other fields of /link, by name."""
        return self._devices.link_status()

    @property
    def accelerometer_faults(self) -> int:
        """Number of reads of the accelerometer without a sample."""
        return self._devices.accelerometer_faults


class MarkedMethod:
    """A method; implements stillarm.controller.estimation.estimate.Method."""

    def __init__(self, method: Method, meter: SectionMeter) -> None:
        """Mark the section of `method`."""
        self._method, self._meter = method, meter

    def update(self, observation: Observation) -> Estimate:
        """As the method's."""
        meter = self._meter
        meter.end(Section.DECIDE)
        estimate = self._method.update(observation)
        meter.end(Section.ESTIMATE)
        return estimate


class MarkedClock(CycleClock):
    """The loop's clock. The rig advances before each sleep, outside of every section."""

    def __init__(self, cycle_s: float, origin_s: float, meter: SectionMeter, rig: LoopbackRig) -> None:
        """As CycleClock."""
        super().__init__(cycle_s, origin_s)
        self._clock_cycle_s, self._meter, self._rig = cycle_s, meter, rig
        self.late_ns: list[int] = []
        """How late each cycle began."""

    def wait(self, last: int) -> int:
        """As CycleClock.wait."""
        meter = self._meter
        meter.end(Section.RECORD)
        self._rig.advance(last + 1)
        meter.begin()
        due = super().wait(last)
        meter.end(Section.SLEEP)
        meter.end_cycle()
        self.late_ns.append(late_ns(self, due, self._clock_cycle_s))
        return due


def late_ns(clock: CycleClock, cycle: int, cycle_s: float) -> int:
    """How long after its time a cycle has begun that begins now, ns."""
    return round((time.monotonic() - clock.origin_s - cycle * cycle_s) * 1e9)
