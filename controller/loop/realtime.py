"""Makes an ordinary Linux process keep a 1 ms cycle, as far as its privileges allow.

The measures: one pinned thread under SCHED_FIFO; memory locked and kept by the allocator; the collector frozen; the
processors kept from sleep states with a slow wake-up. Processes started later have ordinary priority again, but are
also pinned: start them before.
"""

import ctypes
import gc
import os
import resource
from pathlib import Path
from typing import NamedTuple

from stillarm.common.process.blas_threads import BLAS_THREADS
from stillarm.common.process.loop_processor import loop_processor
from stillarm.common.process.priority import run_fifo

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4  # malloc.h
PRIORITY = 60  # SCHED_FIFO, above all other processes of the rig: docs/realtime.md, Other processes
_CPU_LATENCY = Path("/dev/cpu_dma_latency")
_UNIT = "in a systemd unit"


class Missing(NamedTuple):
    """A missing privilege, and the way to grant it."""

    what: str
    grant: str

    def __str__(self) -> str:
        return f"{self.what} (grant: {self.grant})"


FIFO = Missing(
    "SCHED_FIFO is not allowed",
    f"LimitRTPRIO=99 {_UNIT}, or `USER - rtprio 99` in /etc/security/limits.conf, or "
    "`setcap cap_sys_nice,cap_ipc_lock+ep` on the environment's own copy of the Python program",
)
MEMORY = Missing(
    "memory cannot be locked",
    f"LimitMEMLOCK=infinity {_UNIT}, or `USER - memlock unlimited` in /etc/security/limits.conf, or cap_ipc_lock",
)
CPU_LATENCY = Missing(
    f"{_CPU_LATENCY} cannot be opened, so the processor may sleep deeply",
    'a udev rule KERNEL=="cpu_dma_latency", GROUP="realtime", MODE="0660", and the user in that group',
)
PINNED = Missing(
    "the thread is not pinned to a processor", f"AllowedCPUs= {_UNIT} with at least one processor"
)
THREADS = Missing(
    "other threads run in this process",
    f"{', '.join(f'{name}=1' for name in BLAS_THREADS)} in the environment",
)


def missing_privileges() -> list[Missing]:
    """The privileges that enter() would lack. Changes nothing, so that a daemon can refuse before it begins."""
    missing = []
    try:
        before = os.sched_getscheduler(0), os.sched_getparam(0)
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(PRIORITY))
        os.sched_setscheduler(0, before[0], before[1])
    except (OSError, AttributeError):
        missing.append(FIFO)
    if not _may_lock_memory():
        missing.append(MEMORY)
    if _CPU_LATENCY.exists() and not os.access(_CPU_LATENCY, os.R_OK | os.W_OK):
        missing.append(CPU_LATENCY)
    return missing


def _may_lock_memory() -> bool:
    """Whether all present and future memory may be locked: without limit, or by capability. No page is fetched for it:
    a process of a gigabyte would be held for seconds."""
    if resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY:
        return True
    libc = ctypes.CDLL(None, use_errno=True)
    allowed: bool = libc.mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT) == 0
    libc.munlockall()
    return allowed


class RealTime:
    """Real-time operation of this thread, from enter() to leave()."""

    def __init__(self) -> None:
        """Changes nothing."""
        self._latency = -1

    def enter(self) -> list[Missing]:
        """Apply every allowed measure. Returns those that are not allowed; an empty list if all are in force.

        Call it last, after all processes and imports.
        """
        missing = []
        gc.collect()
        gc.freeze()
        gc.disable()
        libc = ctypes.CDLL(None, use_errno=True)
        if hasattr(libc, "mallopt"):  # keep freed memory, and use it for large blocks, too
            libc.mallopt(_M_TRIM_THRESHOLD, ctypes.c_int(2**31 - 1))
            libc.mallopt(_M_MMAP_MAX, 0)
        if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) != 0:
            missing.append(MEMORY)
        try:
            self._latency = os.open(_CPU_LATENCY, os.O_RDWR)
            os.write(self._latency, (0).to_bytes(4, "little"))  # us, in force while the file is open
        except FileNotFoundError:  # a kernel without this file
            pass
        except OSError:
            missing.append(CPU_LATENCY)
        try:
            os.sched_setaffinity(0, {loop_processor()})
        except (OSError, AttributeError):
            missing.append(PINNED)
        if not run_fifo(PRIORITY):
            missing.append(FIFO)
        if _threads() > 1:
            missing.append(THREADS)
        return missing

    def leave(self) -> None:
        """Undo the measures except scheduling and pinning; may be called twice."""
        gc.enable()
        gc.unfreeze()
        ctypes.CDLL(None, use_errno=True).munlockall()
        if self._latency >= 0:
            os.close(self._latency)
            self._latency = -1


def _threads() -> int:
    tasks = Path("/proc/self/task")
    return len(list(tasks.iterdir())) if tasks.is_dir() else 1
