"""A ringing arm in closed loop with the controller's step; a plan replaces readings by odd values.

The arm is exact and cheap: an undamped free vibration of known amplitude, plus the model's response to the joint.
"""

import time
from collections import deque
from dataclasses import dataclass, field
from math import cos, isfinite, pi, sin
from types import FunctionType, MethodType
from typing import Any, NamedTuple

import msgspec
import numpy as np

from stillarm.common.datagrams.visual_sample import VisualSample
from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.model import Accelerometer, Arm, Mode, Model
from stillarm.controller.estimation.estimate import Status
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.joint.drive_model import DriveModel
from stillarm.controller.joint.modal_response import ModalResponse
from stillarm.controller.loop.step import Controller, CycleOutput

CYCLE_S = 0.001
AMPLITUDE_M = 0.006
DELAY_S = 0.074
MODEL = Model(
    arm=Arm(length_m=2.0, modes=[Mode(damping_ratio=0.0005)]),
    accelerometer=Accelerometer(noise_std_m_s2=0.3),
)
PERIOD_CYCLES = 15
SAMPLE_FIELDS = frozenset(VisualSample.__struct_fields__)


class Odd(NamedTuple):
    """From `start`, in cycles after the plan's beginning, the field is `value` in `times` cycles (or samples).

    field: of CycleInput or VisualSample; "pause": the loop stands still for `value` cycles, once; "samples": the
    sample arrives `value` times in the cycle.
    """

    start: int
    field: str
    value: Any
    times: int = 1


class Plan(NamedTuple):
    """damping: whether the damping is allowed while values are odd."""

    odd: tuple[Odd, ...]
    damping: bool = False


@dataclass
class Verdict:
    """Result of a run. faults: in words; empty if there are none.

    step_ns: processor time of each step. error: largest error of the deflection at the end, over the amplitude.
    failures: number of restarts of the method after its numbers failed. not_numbers: where its state contains NaN.
    """

    faults: list[str] = field(default_factory=list)
    step_ns: list[int] = field(default_factory=list)
    error: float = 0.0
    refused: int = 0
    failures: int = 0
    not_numbers: list[str] = field(default_factory=list)


class World:
    """Controller, joint and arm."""

    def __init__(self, method: str) -> None:
        """The joint is at rest; the arm vibrates."""
        self.controller = Controller(MODEL, Settings(method=method))
        mode, length = MODEL.arm.modes[0], MODEL.arm.length_m
        assert length is not None
        self._w, self._length, self._participation = mode.angular_frequency, length, mode.participation
        self._drive, self._response = DriveModel(MODEL.drive, CYCLE_S), ModalResponse(mode, length, CYCLE_S)
        self._tips: list[tuple[int, float]] = []  # in transit: cycle of exposure, position
        self.cycle = 0
        self._frame = 0
        self._command = 0.0

    @property
    def deflection_m(self) -> float:
        """The present deflection."""
        return self._free() + self._response.deflection_m

    def _free(self) -> float:
        return AMPLITUDE_M * cos(self._w * self.cycle * CYCLE_S)

    def read(self, damping: bool) -> CycleInput:
        """The true sensor readings of this cycle."""
        cycle, w, drive = self.cycle, self._w, self._drive
        bent = -w * w * self.deflection_m
        rigid = (1.0 - self._participation) * self._length * drive.acceleration_rad_s2
        noise = 0.3 * sin(12345.6 * cycle % (2.0 * pi))
        read = CycleInput(
            cycle,
            bent + rigid + noise,
            drive.position_rad,
            drive.velocity_rad_s,
            0.001,
            0.0,
            damping,
            operator=0,
        )
        if cycle % PERIOD_CYCLES == 0:
            self._tips.append((cycle, self._length * drive.position_rad + self.deflection_m))
        while self._tips and cycle - self._tips[0][0] >= round(DELAY_S / CYCLE_S):
            exposed, tip = self._tips.pop(0)
            read.samples.append(
                VisualSample(
                    exposed // PERIOD_CYCLES, exposed, 0, 20.0 - 800.0 * tip,
                    variance_x_px2=0.0025, captured_s=100.0 + exposed * CYCLE_S,
                )
            )  # fmt: skip
        return read

    def advance(self, command_rad_s: float) -> None:
        """Advance to the next cycle."""
        self._command = command_rad_s
        self._drive.advance(command_rad_s)
        self._response.advance(self._drive.mean_acceleration_rad_s2)
        self.cycle += 1

    def pause(self, cycles: int) -> None:
        """Stop the loop for some cycles: the drive stops by itself, and images exposed in that time are lost."""
        if self._drive.velocity_rad_s:
            self._drive.rest_at(self._drive.position_rad)
        self._response.advance_many(cycles, 0.0)
        self._tips.clear()
        self.cycle += cycles


WARM_CYCLES = 2500
RECOVER_CYCLES = 2000
JUDGED_CYCLES = 400
_STILL_WRONG = 0.15  # of the amplitude; or twice the error without odd values, if that is more


def warmed(method: str) -> World:
    """A world whose estimate has settled."""
    world = World(method)
    for _ in range(WARM_CYCLES):
        world.advance(world.controller.step(world.read(False)).command_rad_s)
    return world


def run(
    world: World,
    plan: Plan,
    usual_error: float | None = None,
    *,
    further: int = RECOVER_CYCLES + JUDGED_CYCLES,
) -> Verdict:
    """Run a plan and `further` cycles, after which the estimate must have recovered.

    usual_error: Verdict.error without odd values.
    """
    verdict = Verdict()
    pending = sorted(plan.odd, key=lambda one: one.start)
    active, since = list[list[Any]](), 0
    limit = MODEL.drive.max_velocity_rad_s
    seen = 0
    while since < further:
        while pending and pending[0].start <= seen:
            one = pending.pop(0)
            if one.field == "pause":
                world.pause(one.value)
            else:
                active.append([one, one.times])
        odd_phase = bool(pending or active)
        read = world.read(plan.damping and odd_phase)
        _make_odd(read, active)
        before = time.thread_time_ns()
        answered = world.controller.step(read)
        verdict.step_ns.append(time.thread_time_ns() - before)
        command = answered.command_rad_s
        if not (isfinite(command) and abs(command) <= limit):
            verdict.faults.append(f"command {command!r} in cycle {seen}")
            break
        active = [one for one in active if one[1] > 0]
        since = 0 if pending or active else since + 1
        if since > RECOVER_CYCLES:
            _judge(world, answered, verdict)
        world.advance(command)
        seen += 1
    verdict.refused = sum(world.controller.refused)
    method: Any = world.controller.method
    verdict.failures = method.failures
    verdict.not_numbers = sorted(not_numbers(method))
    if usual_error is not None and not verdict.error <= max(_STILL_WRONG, 2.0 * usual_error):
        verdict.faults.append(f"the estimate is off by {verdict.error:.3g} of the amplitude")
    return verdict


def _make_odd(read: CycleInput, active: list[list[Any]]) -> None:
    for one in active:
        name, value = one[0].field, one[0].value
        if name == "samples":
            if read.samples:
                read.samples = read.samples * value
                one[1] -= 1
        elif name in SAMPLE_FIELDS:
            if read.samples:
                read.samples = [msgspec.structs.replace(each, **{name: value}) for each in read.samples]
                one[1] -= 1
        else:
            setattr(read, name, value)
            one[1] -= 1


def _judge(world: World, answered: CycleOutput, verdict: Verdict) -> None:
    estimate = answered.estimate
    if estimate.status not in (Status.ESTIMATED, Status.HELD):
        verdict.faults.append(f"the estimate is {estimate.status} 2 s after the last odd value")
        verdict.error = float("inf")
    off = abs(estimate.deflection_m - world.deflection_m) / AMPLITUDE_M
    verdict.error = max(verdict.error, off if isfinite(off) else float("inf"))


def not_numbers(root: object) -> set[str]:
    """Attribute paths to NaN in an object's state. All places in a container or array count as one."""
    found: set[str] = set()
    known: set[int] = set()
    waiting: list[tuple[str, Any]] = [("", root)]
    while waiting:
        path, one = waiting.pop()
        if isinstance(one, float | complex):
            if one != one:  # noqa: PLR0124
                found.add(path)
            continue
        if isinstance(one, np.ndarray):
            if one.dtype.kind in "fc" and np.isnan(one).any():
                found.add(path)
            continue
        if id(one) in known or isinstance(one, type | FunctionType | MethodType):
            continue
        known.add(id(one))
        if isinstance(one, dict):
            waiting += [(f"{path}[]", each) for each in one.values()]
        elif isinstance(one, list | tuple | deque):
            waiting += [(f"{path}[]", each) for each in one]
        elif type(one).__module__.startswith(("stillarm.controller.", "stillarm.common.")):
            names: Any = getattr(one, "__dict__", None) or getattr(type(one), "__slots__", ())
            waiting += [(f"{path}.{name}", getattr(one, name, None)) for name in names]
    return found
