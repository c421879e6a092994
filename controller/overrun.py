"""Why a cycle was missed, as far as cheap counters can tell.

The loop reads them only when it has missed a cycle; what has no counter at the loop (the processor's clock and its
throttling) the statistics process adds.
"""

import os
import resource
from enum import StrEnum
from typing import NamedTuple


class Cause(StrEnum):
    """The likely cause of a missed cycle."""

    PAGE_FAULT = "page fault"
    SLOW_BUS = "slow bus"
    NO_CPU = "no CPU"
    THROTTLING = "throttling"
    OWN_COMPUTING = "our own computing"


REMEDY = {
    Cause.PAGE_FAULT: "grant CAP_IPC_LOCK (or LimitMEMLOCK=infinity), so that memory stays locked",
    Cause.SLOW_BUS: "read the accelerometer faster (I2C at 400 kHz or more), or look for its faults",
    Cause.NO_CPU: "keep other work off this processor (isolcpus=, a higher real-time priority); a virtual machine's "
    "processors may be taken away",
    Cause.THROTTLING: "cool the processor, or set its governor to performance",
    Cause.OWN_COMPUTING: "choose a cheaper controller.method, or a longer timing.cycle_s",
}


class OverrunCounters(NamedTuple):
    """One overrun: what its cycle took, and what the counters moved by since they were read last.

    late_s: from when the cycle was due until it began. device_s, computing_s: parts of the cycle.
    run_delay_s: ready to run, but waiting for a processor. throttled: whether the processor was slowed down meanwhile.
    stolen_s: for how long the machine that runs this one took the processor away, in the second around it.
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


def overrun_cause(seen: OverrunCounters) -> Cause:
    """The likely cause, the most certain evidence first.

    1. A page that had to come from a disk, or more new pages than a quarter of the missed time needs at 0.5 us each.
    2. A wake-up that came more than half a cycle late, or half of the missed time spent waiting for a processor, or a
       processor that was taken away for half of it, or a switch away from the thread during its own computing: somebody
       else had the processor.
    3. Most of the cycle went into the devices.
    4. The processor ran slower than it can.
    5. What is left: we took too long.
    """
    missed_s = max(seen.late_s + seen.device_s + seen.computing_s, seen.cycle_s)
    if seen.major_faults > 0 or seen.minor_faults * 0.5e-6 > 0.25 * missed_s:
        return Cause.PAGE_FAULT
    if seen.late_s > 0.5 * seen.cycle_s or max(seen.run_delay_s, seen.stolen_s) > 0.5 * missed_s:
        return Cause.NO_CPU
    if seen.device_s > 0.5 * missed_s and seen.device_s > seen.computing_s:
        return Cause.SLOW_BUS
    if seen.involuntary_switches > 0:
        return Cause.NO_CPU
    return Cause.THROTTLING if seen.throttled else Cause.OWN_COMPUTING


class ThreadCounters:
    """This thread's counters, as differences from one reading to the next; 3 us each."""

    def __init__(self) -> None:
        """Opens /proc/thread-self/schedstat where the kernel offers it."""
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
