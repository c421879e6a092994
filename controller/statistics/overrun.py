"""The likely cause of a missed cycle, from cheap counters.

The loop reads the counters only after it has missed a cycle. The statistics process adds data without a counter in the
loop (the processor's clock and its throttling).
"""

import os
import resource
from enum import StrEnum
from typing import NamedTuple


class OverrunCause(StrEnum):
    """The likely cause of a missed cycle."""

    PAGE_FAULT = "page fault"
    SLOW_BUS = "slow bus"
    NO_CPU = "no CPU"
    THROTTLING = "throttling"
    OWN_COMPUTING = "our own computing"


REMEDY = {
    OverrunCause.PAGE_FAULT: "grant CAP_IPC_LOCK (or LimitMEMLOCK=infinity), so that memory stays locked",
    OverrunCause.SLOW_BUS: "read the accelerometer faster (I2C at 400 kHz or more), or look for its faults",
    OverrunCause.NO_CPU: "keep other work off this processor (isolcpus=, a higher real-time priority); a virtual "
    "machine's processors may be taken away",
    OverrunCause.THROTTLING: "cool the processor, or set its governor to performance",
    OverrunCause.OWN_COMPUTING: "choose a cheaper controller.method, or a longer timing.cycle_s",
}


class OverrunCounters(NamedTuple):
    """One overrun: the times of its cycle, and the increments of the counters since their last reading.

    late_s: from the due time of the cycle to its start. device_s, computing_s: parts of the cycle.
    run_delay_s: ready to run, but waiting for a processor. throttled: whether the processor was slowed down.
    stolen_s: time that the hypervisor took the processor away, in the second around the overrun.
    """

    cycle_s: float
    late_s: float
    device_s: float
    computing_s: float
    minor_faults: int = 0
    major_faults: int = 0
    voluntary_switches: int = 0
    involuntary_switches: int = 0
    run_delay_s: float = 0.0
    throttled: bool = False
    stolen_s: float = 0.0


def overrun_cause(seen: OverrunCounters) -> OverrunCause:
    """The likely cause, the most certain evidence first.

    1. Page fault: a page from a disk, or new pages that took a quarter of the missed time at 0.5 us each.
    2. No CPU: a wake-up more than half a cycle late, half of the missed time spent waiting for a processor, a processor
       taken away for half of it, or preemption during the computing.
    3. Slow bus: the devices took most of the cycle.
    4. Throttling: the processor ran below its maximum clock.
    5. Otherwise: our own computing took too long.
    """
    missed_s = max(seen.late_s + seen.device_s + seen.computing_s, seen.cycle_s)
    if seen.major_faults > 0 or seen.minor_faults * 0.5e-6 > 0.25 * missed_s:
        return OverrunCause.PAGE_FAULT
    if seen.late_s > 0.5 * seen.cycle_s or max(seen.run_delay_s, seen.stolen_s) > 0.5 * missed_s:
        return OverrunCause.NO_CPU
    if seen.device_s > 0.5 * missed_s and seen.device_s > seen.computing_s:
        return OverrunCause.SLOW_BUS
    if seen.involuntary_switches > 0:
        return OverrunCause.NO_CPU
    return OverrunCause.THROTTLING if seen.throttled else OverrunCause.OWN_COMPUTING


class ThreadCounters:
    """This thread's counters, as differences from one reading to the next; 3 us each."""

    def __init__(self) -> None:
        """Open /proc/thread-self/schedstat if the kernel has it."""
        try:
            self._schedstat = os.open("/proc/thread-self/schedstat", os.O_RDONLY)
        except OSError:
            self._schedstat = -1
        self._last = self._read()

    def _read(self) -> tuple[int, int, int, int, int]:
        used = resource.getrusage(resource.RUSAGE_THREAD)
        waited = 0
        if self._schedstat >= 0:
            waited = int(os.pread(self._schedstat, 64, 0).split()[1])
        return used.ru_minflt, used.ru_majflt, used.ru_nvcsw, used.ru_nivcsw, waited

    def moved(self) -> tuple[int, int, int, int, int]:
        """Minor and major faults, voluntary and involuntary switches, and ns of waiting, since the last call."""
        now, last = self._read(), self._last
        self._last = now
        return now[0] - last[0], now[1] - last[1], now[2] - last[2], now[3] - last[3], now[4] - last[4]

    def close(self) -> None:
        """Release the descriptor; may be called twice."""
        if self._schedstat >= 0:
            os.close(self._schedstat)
            self._schedstat = -1
