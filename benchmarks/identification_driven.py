"""Ours on a measured pair of a force and an acceleration, by the way of joints that a torque drives."""

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.identification_data import Pair
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.driven.blocks import irregular
from stillarm.diagnosis.driven.decide import decide
from stillarm.diagnosis.driven.fitting import fit
from stillarm.diagnosis.driven.search import search
from stillarm.diagnosis.driven.signals import Driven, Output, counter_step

Array = NDArray[np.float64]

_BUDGET_S = 60.0  # the default of `stillarm diagnose`


def as_driven(pair: Pair) -> tuple[Array, str]:
    """The way of joints that a torque drives, on the samples that are fitted; then one free run over the others."""
    ended = time.monotonic() + _BUDGET_S

    def left_s() -> float:
        return ended - time.monotonic()

    def read(span: slice) -> Driven:
        seen = Output("acceleration_m_s2", "acceleration", pair.y[span], False, counter_step(pair.y))
        return Driven(
            pair.name, 1.0 / pair.rate_hz, 0.0, "joint_torque_command_n_m", pair.u[span], False, (seen,), {}
        )

    driven = read(pair.train)
    verdict = decide(search(driven, irregular(driven.duration_s), lambda done, what: None, left_s), left_s)
    other = read(pair.test)
    whole = Split(np.array([0.0, other.duration_s]), np.zeros(1, bool))
    box = replace(verdict.final.box, driven=other, split=whole)
    shown = fit(box, verdict.final.numbers, ()).run.outputs["acceleration_m_s2"]
    said = ", ".join(one.form.cause for one in verdict.findings) or "no cause"
    return shown, f"{verdict.verdict}: {said}; linear, with {box.modes} modes"
