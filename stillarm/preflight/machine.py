"""Checks the machine: privileges, kernel, processor governor."""

import os
import platform
from dataclasses import dataclass
from pathlib import Path

from stillarm.controller.loop.realtime import missing_privileges
from stillarm.preflight.verdict import Verdict, fail, ok, warn

_WHERE = "machine"
_GOVERNORS = "devices/system/cpu/cpu*/cpufreq/scaling_governor"


@dataclass(frozen=True)
class MachineFacts:
    """What was observed of the machine.

    missing: privileges that the controller lacks, each with the way to grant it. governors: of the processors; empty
    if the machine has none.
    """

    missing: tuple[str, ...]
    kernel: str
    preempt_rt: bool
    governors: frozenset[str]
    processors: int


def look_at_machine() -> MachineFacts:
    """Read the kernel's settings; changes nothing."""
    realtime = Path("/sys/kernel/realtime")
    flagged = realtime.read_text().strip() == "1" if realtime.exists() else False
    governors = set()
    for path in Path("/sys").glob(_GOVERNORS):
        try:
            governors.add(path.read_text().strip())
        except OSError:  # a processor that is switched off
            continue
    return MachineFacts(
        tuple(str(missing) for missing in missing_privileges()),
        platform.release(),
        flagged or "PREEMPT_RT" in platform.version(),
        frozenset(governors),
        len(os.sched_getaffinity(0)),
    )


def judge_machine(facts: MachineFacts, *, emulated: bool) -> list[Verdict]:
    """Judge the machine. emulated: whether the rig is simulated, which does not require real time."""
    verdicts = [
        warn(_WHERE, f"{missing}; the controller then needs --allow-non-realtime")
        if emulated
        else fail(_WHERE, f"{missing}; the controller does not start without it")
        for missing in facts.missing
    ] or [ok(_WHERE, "all privileges for real-time operation are granted")]
    if facts.preempt_rt:
        verdicts.append(ok(_WHERE, f"kernel {facts.kernel} with PREEMPT_RT"))
    else:
        verdicts.append(
            warn(
                _WHERE,
                f"kernel {facts.kernel} without PREEMPT_RT: wake-ups may be milliseconds late under load; "
                "`stillarm latency` measures it; install a real-time kernel (Debian: linux-image-rt-amd64)",
            )
        )
    slow = facts.governors - {"performance"}
    if slow:
        verdicts.append(
            warn(
                _WHERE,
                f"processor governor {', '.join(sorted(slow))}: the clock slows down between cycles; "
                "`cpupower frequency-set -g performance`",
            )
        )
    elif facts.governors:
        verdicts.append(ok(_WHERE, "processor governor performance"))
    if facts.processors < 2:
        verdicts.append(
            warn(
                _WHERE, "one processor only: the loop shares it with everything else; use a machine with two"
            )
        )
    return verdicts
