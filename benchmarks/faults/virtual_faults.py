"""The faults in virtual time, as a table, and a function that injects them repeatedly."""

import random
from collections.abc import Callable
from dataclasses import dataclass

from stillarm.benchmarks.faults.faulty_link import PERFECT, LinkFault
from stillarm.benchmarks.faults.judge import Trace, Verdict, judge
from stillarm.benchmarks.faults.virtual_rig import CYCLE_S, VirtualRig
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.drivers.emulated_chips.shared_registers import Failure

_SETTLE_CYCLES = 2500  # from a start until damping is surely on

Act = Callable[[VirtualRig], None]


@dataclass(frozen=True)
class VirtualFault:
    """The actions at a fault's beginning and end, and its shortest and longest duration, s.

    groundless: whether a command has no grounds during the fault. images: whether real images are rendered and tracked.
    back: whether damping must return afterwards.
    """

    begin: Act
    end: Act
    shortest_s: float = 0.3
    longest_s: float = 1.0
    groundless: bool = False
    images: bool = False
    back: bool = True
    fresh: bool = False  # use a new rig for each injection
    back_within_s: float = 1.6


def _link(up: LinkFault, down: LinkFault | None = None) -> tuple[Act, Act]:
    def begin(rig: VirtualRig) -> None:
        rig.up.fault, rig.down.fault = up, up if down is None else down

    def end(rig: VirtualRig) -> None:
        rig.up.fault = rig.down.fault = PERFECT

    return begin, end


def _drive(commands: LinkFault, states: LinkFault) -> tuple[Act, Act]:
    def begin(rig: VirtualRig) -> None:
        rig.commands.fault, rig.states.fault = commands, states

    def end(rig: VirtualRig) -> None:
        rig.commands.fault = rig.states.fault = PERFECT

    return begin, end


def _accelerometer(failure: Failure) -> tuple[Act, Act]:
    return lambda rig: rig.accelerometer.inject(failure), lambda rig: rig.accelerometer.inject(Failure.NONE)


def _set(name: str, value: object, back: object) -> tuple[Act, Act]:
    return lambda rig: setattr(rig, name, value), lambda rig: setattr(rig, name, back)


def _restart(runs: str, start: str) -> tuple[Act, Act]:
    return lambda rig: setattr(rig, runs, False), lambda rig: getattr(rig, start)()


def _spoil(how: str, frames: int) -> tuple[Act, Act]:
    def begin(rig: VirtualRig) -> None:
        rig.spoil, rig.spoil_frame = how, frames

    def end(rig: VirtualRig) -> None:
        rig.spoil_frame = 0

    return begin, end


_ALL, _MANY = LinkFault(drop=1.0), 10**6
FAULTS: dict[str, VirtualFault] = {
    "link cut": VirtualFault(*_link(_ALL), groundless=True),
    "link cut towards the controller": VirtualFault(*_link(_ALL, PERFECT), groundless=True),
    "link loses 30 %": VirtualFault(*_link(LinkFault(drop=0.3))),
    "link delays by up to 20 ms": VirtualFault(*_link(LinkFault(jitter_s=0.02))),
    "link delays by 0.4 s": VirtualFault(*_link(LinkFault(delay_s=0.4)), groundless=True),
    "link duplicates": VirtualFault(*_link(LinkFault(duplicate=1.0))),
    "link reorders": VirtualFault(*_link(LinkFault(reorder=0.3))),
    "link corrupts 30 %": VirtualFault(*_link(LinkFault(corrupt=0.3))),
    "link corrupts all": VirtualFault(*_link(LinkFault(corrupt=1.0)), groundless=True),
    "link truncates all": VirtualFault(*_link(LinkFault(truncate=1.0)), groundless=True),
    "link pads 50 %": VirtualFault(*_link(LinkFault(oversize=0.5))),
    "link replays": VirtualFault(*_link(LinkFault(replay=10))),
    "link forges": VirtualFault(*_link(LinkFault(forge=15))),
    "drive link cut": VirtualFault(*_drive(_ALL, _ALL), groundless=True),
    "commands cut": VirtualFault(*_drive(_ALL, PERFECT), groundless=True),
    "drive states cut": VirtualFault(*_drive(PERFECT, _ALL), groundless=True),
    "drive link corrupts 30 %": VirtualFault(*_drive(LinkFault(corrupt=0.3), LinkFault(corrupt=0.3))),
    "drive link corrupts all": VirtualFault(*_drive(LinkFault(corrupt=1.0), LinkFault(corrupt=1.0)), groundless=True),
    "drive link replays and forges": VirtualFault(
        *_drive(LinkFault(replay=10, forge=10), LinkFault(replay=10, forge=10))
    ),
    "drive link reorders and delays": VirtualFault(
        *_drive(LinkFault(reorder=0.2, jitter_s=0.003), LinkFault(reorder=0.2, jitter_s=0.003))
    ),
    "supervisor killed": VirtualFault(*_restart("supervisor_runs", "start_supervisor"), groundless=True),
    "supervisor stopped": VirtualFault(*_set("supervisor_runs", False, True), groundless=True),
    "controller killed": VirtualFault(*_restart("controller_runs", "start_controller"), groundless=True),
    "controller stopped": VirtualFault(*_set("controller_runs", False, True), groundless=True, back_within_s=4.0),
    "gateway restarted": VirtualFault(*_restart("gateway_runs", "start_gateway"), groundless=True),
    "camera stalls": VirtualFault(*_set("camera_stalled", True, False), groundless=True),
    "images frozen": VirtualFault(*_spoil("frozen", _MANY), groundless=True, images=True),
    "images dark": VirtualFault(*_spoil("dark", _MANY), groundless=True, images=True),
    "flash": VirtualFault(*_spoil("flash", 3), images=True, longest_s=0.5),
    "images of noise": VirtualFault(*_spoil("noise", _MANY), groundless=True, images=True),
    "displacements not a number": VirtualFault(*_spoil("nan", _MANY), groundless=True),
    "displacements infinite": VirtualFault(*_spoil("infinite", _MANY), groundless=True),
    "displacements wild": VirtualFault(*_spoil("wild", 10), back=False, fresh=True),
    "accelerometer does not answer": VirtualFault(*_accelerometer(Failure.NAK)),
    "accelerometer stuck": VirtualFault(*_accelerometer(Failure.STUCK)),
    "accelerometer garbage": VirtualFault(*_accelerometer(Failure.GARBAGE), back=False, fresh=True),
    "accelerometer unplugged": VirtualFault(*_accelerometer(Failure.UNPLUGGED)),
    "clock step": VirtualFault(*_set("clock_step_s", 3600.0, -7.0)),
    "damping not allowed": VirtualFault(*_set("damping_allowed", False, True), groundless=True),
}  # fmt: skip
"""Faults by name. A dead accelerometer is not groundless: the damping continues with the last known delay."""


def run_virtual_fault(
    kind: str, configuration: Configuration, model: Model, times: int, seed: int
) -> list[Verdict]:
    """Inject one kind of fault `times` times, at random moments and for random durations, into a damped rig."""
    fault, rng = FAULTS[kind], random.Random(f"{kind} {seed}")
    verdicts: list[Verdict] = []
    rig: VirtualRig | None = None
    for count in range(times):
        if rig is None:
            rig = VirtualRig(configuration, model, seed + count, images=fault.images)
            for _ in range(_SETTLE_CYCLES):
                rig.step()
        verdicts.append(_inject(kind, fault, rig, rng))
        if fault.fresh or verdicts[-1].violations:  # the next injection must be judged separately
            rig.close()
            rig = None
    if rig is not None:
        rig.close()
    return verdicts


def _inject(kind: str, fault: VirtualFault, rig: VirtualRig, rng: random.Random) -> Verdict:
    for _ in range(rng.randrange(400)):
        rig.step()
    lasts = round(rng.uniform(fault.shortest_s, fault.longest_s) / CYCLE_S)
    commands: list[float] = []
    before = rig.exchange.counts.lost
    fault.begin(rig)
    for _ in range(lasts):
        rig.step()
        commands.append(rig.command_rad_s)
    fault.end(rig)
    recovery = round(fault.back_within_s / CYCLE_S)
    for _ in range(recovery):
        rig.step()
        commands.append(rig.command_rad_s)
    return judge(
        kind,
        Trace([i * CYCLE_S for i in range(len(commands))], commands),
        limit_rad_s=rig.model.drive.max_velocity_rad_s,
        groundless_s=(0.0, lasts * CYCLE_S) if fault.groundless else None,
        back_by_s=(lasts + recovery) * CYCLE_S if fault.back else None,
        messages_lost=max(0, rig.exchange.counts.lost - before),
    )
