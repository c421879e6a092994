"""The faults for the real processes, in real time."""

import random
import resource
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass

from stillarm.benchmarks.faults.faulty_link import PERFECT, LinkFault
from stillarm.benchmarks.faults.flood_sender import RATE_HZ, sent_by, start_flood
from stillarm.benchmarks.faults.judge import Verdict, judge
from stillarm.benchmarks.faults.live_rig import LiveRig
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.drivers.emulated_chips.shared_registers import Failure

LAST_SECOND_S = 1.0
_FLOOD_S = 2.0
_AFTER_S = 1.0  # the time after the first command is judged, too
_BACK_WITHIN_S = 12.0  # a restarted process first loads its libraries

Act = Callable[[LiveRig], None]


@dataclass(frozen=True)
class LiveFault:
    """As VirtualFault. restart: the process that is restarted when the fault is over.

    recording: if not empty, the recording is judged: it ends with the fault ("cut") or is complete ("whole").
    """

    begin: Act
    end: Act
    groundless: bool = False
    restart: str = ""
    recording: str = ""
    lasts_s: tuple[float, float] = (0.3, 0.8)


def _nothing(rig: LiveRig) -> None:
    """Do nothing."""


def _links(**faults: LinkFault) -> tuple[Act, Act]:
    def begin(rig: LiveRig) -> None:
        for way, fault in faults.items():
            getattr(rig.proxy, way).fault = fault

    def end(rig: LiveRig) -> None:
        for way in faults:
            getattr(rig.proxy, way).fault = PERFECT

    return begin, end


def _stopped(name: str) -> tuple[Act, Act]:
    return lambda rig: rig.signal(name, signal.SIGSTOP), lambda rig: rig.signal(name, signal.SIGCONT)


def _killed(name: str) -> tuple[Act, Act]:
    return lambda rig: rig.signal(name, signal.SIGKILL), _nothing


def _accelerometer(failure: Failure) -> tuple[Act, Act]:
    return lambda rig: rig.fail_accelerometer(failure), lambda rig: rig.fail_accelerometer(Failure.NONE)


def _full_disk(rig: LiveRig) -> None:
    size = rig.recording.stat().st_size
    resource.prlimit(rig.process_id("controller/recorder"), resource.RLIMIT_FSIZE, (size, size))


def _flood(rig: LiveRig) -> None:
    rig.flood = start_flood(rig.proxy.up.past, rig.controller_port, RATE_HZ, _FLOOD_S, 5)


def _flooded(rig: LiveRig) -> None:
    if rig.flood is not None:
        sent_by(rig.flood)


_CUT = LinkFault(drop=1.0)
_BAD = LinkFault(
    drop=0.1, corrupt=0.1, duplicate=0.2, reorder=0.2, truncate=0.05, oversize=0.05, replay=2, forge=3
)
FAULTS: dict[str, LiveFault] = {
    "live: link cut": LiveFault(*_links(up=_CUT, down=_CUT), groundless=True),
    "live: link bad in every way": LiveFault(*_links(up=_BAD, down=_BAD)),
    "live: drive link cut": LiveFault(*_links(commands=_CUT, states=_CUT), groundless=True),
    "live: drive link bad in every way": LiveFault(*_links(commands=_BAD, states=_BAD)),
    "live: flood of 20 000 datagrams/s": LiveFault(_flood, _flooded, lasts_s=(_FLOOD_S, _FLOOD_S)),
    "live: supervisor stopped": LiveFault(*_stopped("supervisor"), groundless=True),
    "live: supervisor killed": LiveFault(*_killed("supervisor"), groundless=True, restart="supervisor"),
    "live: camera stopped": LiveFault(*_stopped("rig/camera"), groundless=True),
    "live: rig stopped": LiveFault(*_stopped("rig"), groundless=True),
    "live: accelerometer does not answer": LiveFault(*_accelerometer(Failure.NAK)),
    "live: accelerometer stuck": LiveFault(*_accelerometer(Failure.STUCK)),
    "live: accelerometer garbage": LiveFault(*_accelerometer(Failure.GARBAGE)),
    "live: controller stopped": LiveFault(*_stopped("controller"), groundless=True),
    "live: recorder stopped": LiveFault(*_stopped("controller/recorder")),
    "live: controller killed": LiveFault(
        *_killed("controller"), groundless=True, restart="controller", recording="whole"
    ),
    "live: controller asked to stop": LiveFault(
        lambda rig: rig.signal("controller", signal.SIGTERM), _nothing, True, "controller", "whole"
    ),
    "live: recorder killed": LiveFault(*_killed("controller/recorder"), recording="cut"),
    "live: disk full": LiveFault(_full_disk, _nothing, recording="cut"),
}  # fmt: skip


def run_live_fault(kind: str, rig: LiveRig, rng: random.Random) -> Verdict:
    """Inject one fault into a damped rig, and judge the result. Raises UserError if the rig does not recover."""
    fault = FAULTS[kind]
    rig.proxy.pump(rng.uniform(0.5, 1.0))
    log = rig.log_size("controller")
    began = time.monotonic()
    fault.begin(rig)
    rig.proxy.pump(rng.uniform(*fault.lasts_s))
    ended = time.monotonic()
    fault.end(rig)
    problems: list[str] = []
    lost = 0
    if fault.recording == "cut":  # the controller continues, ends in order, and reports what is missing
        rig.signal("controller", signal.SIGTERM)
        if rig.wait("controller") != 0:
            problems.append("the controller did not end in order")
        if "recover" not in rig.said_since("controller", log):
            problems.append("no message says that the recording is incomplete")
    elif fault.restart:
        rig.wait(fault.restart)
    if fault.recording:
        problems_of, lost = _judge_recording(rig, began)
        problems += problems_of
    if fault.restart or fault.recording == "cut":
        rig.start(fault.restart or "controller")
    try:
        rig.await_command(_BACK_WITHIN_S)
        rig.proxy.pump(_AFTER_S)
    except UserError as error:
        problems.append(f"not back: {error}")
    verdict = judge(
        kind,
        rig.trace(began, time.monotonic()),
        limit_rad_s=rig.model.drive.max_velocity_rad_s,
        groundless_s=(0.0, ended - began) if fault.groundless else None,
        back_by_s=None,
        messages_lost=lost,
    )
    verdict.violations += problems
    return verdict


def _judge_recording(rig: LiveRig, fault_s: float) -> tuple[list[str], int]:
    """The part before the fault that the recording misses: violations, and the number of cycles."""
    time.sleep(0.5)  # a recorder completes its file even after its daemon was killed
    recording = open_recording(rig.recording)
    times = recording.columns("/fast")["time_s"]
    last_s = recording.header.origin_monotonic_s + float(times[-1]) if len(times) else float("-inf")
    missing_s = max(0.0, fault_s - last_s)
    problems = []
    if missing_s > LAST_SECOND_S:
        problems.append(f"{missing_s:.2f} s recorded before the fault are lost; 1 s may be")
    return problems, round(missing_s * 1000.0) if missing_s < 1e6 else 0
