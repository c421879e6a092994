"""Checks which rate the step keeps on this machine, by the method that is configured and by the others.

The step runs at the loop's pace on a synthetic vibration, since its caches are cold after each sleep: without pauses it
would seem to take half as long. The same cycles run three times, and each counts with its least: what other programs
add is no property of the step, and the loop has priority over them.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from math import floor, log10

import msgspec

from stillarm.common.files.configuration import Controller as ControllerSettings
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import METHODS
from stillarm.controller.loop.step import Controller
from stillarm.controller.loop.warm_up import vibration_cycles
from stillarm.preflight.verdict import Verdict, fail, ok, warn

_WHERE = "machine"
_AT_ONCE, _PACED = (
    740,
    160,
)  # cycles: until just after an impact; measured, the beginning anew after it included
_TIMES = 3
_PACE_S = 0.001
REST = 1.3
"""Of a step's median: what a cycle computes beside it. By `stillarm latency` (docs/realtime.md), the other sections'
99th percentiles add up to so much. A transfer on a real bus comes on top: the check of the bus judges it."""


@dataclass(frozen=True)
class StepFacts:
    """Duration of a method's step, s: the median, and the greatest, mostly that of a beginning anew after an impact."""

    method: str
    median_s: float
    greatest_s: float

    @property
    def busiest_s(self) -> float:
        """The cycle that computes longest, s."""
        return self.greatest_s + REST * self.median_s

    @property
    def fastest_hz(self) -> float:
        """The highest rate of the loop that it keeps, rounded down to one digit."""
        rate = 1.0 / self.busiest_s
        digit = 10.0 ** floor(log10(rate))
        return floor(rate / digit) * digit


def check_step(model: Model, settings: ControllerSettings, model_name: str) -> Verdict:
    """Measure all methods, half a second each, and judge."""
    names = dict.fromkeys((settings.method, *METHODS))
    try:
        facts = [measure_step(model, settings, model_name, name) for name in names]
    except UserError as error:  # a model without length, an unknown method
        return fail(_WHERE, str(error))
    return judge_step(facts, model.timing.cycle_s)


def measure_step(model: Model, settings: ControllerSettings, model_name: str, method: str) -> StepFacts:
    """Step a temporary controller. Raises UserError as Controller does."""
    replaced = msgspec.structs.replace(settings, method=method, arm_at_start=True)
    passes = [_pass_ns(model, Controller(model, replaced, model_name)) for _ in range(_TIMES)]
    least_ns = sorted(map(min, *passes))
    return StepFacts(method, least_ns[_PACED // 2] * 1e-9, least_ns[-1] * 1e-9)


def _pass_ns(model: Model, controller: Controller) -> list[int]:
    """How long each paced step took, ns."""
    cycles, took_ns = vibration_cycles(model, _AT_ONCE + _PACED), []
    for read in islice(cycles, _AT_ONCE):
        controller.step(read)
    for read in cycles:
        time.sleep(_PACE_S)
        began = time.perf_counter_ns()
        controller.step(read)
        took_ns.append(time.perf_counter_ns() - began)
    return took_ns


def judge_step(facts: Sequence[StepFacts], cycle_s: float) -> Verdict:
    """Judge the methods, of which the first is the configured one, by the model's cycle."""
    rate_hz, chosen = 1.0 / cycle_s, facts[0]
    takes = (
        f"a step of {chosen.method} takes {chosen.median_s * 1e6:.0f} us, "
        f"{chosen.greatest_s * 1e6:.0f} us at the most"
    )
    if chosen.busiest_s <= cycle_s:
        others = ", ".join(f"{one.method} {one.fastest_hz:g}" for one in facts[1:])
        return ok(_WHERE, f"{takes}: {rate_hz:g} Hz is kept, and up to {chosen.fastest_hz:g} Hz ({others})")
    kept = [one.method for one in facts[1:] if one.busiest_s <= cycle_s]
    other = f", or controller.method = {' or '.join(kept)}, which this machine keeps" if kept else ""
    slower = f"timing.cycle_s = {1.0 / chosen.fastest_hz:.3g} in the model"
    return warn(_WHERE, f"{takes}: too long for {rate_hz:g} Hz; choose {slower}{other}")
