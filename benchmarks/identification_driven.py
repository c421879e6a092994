"""Ours on a measured pair of a force and an acceleration, by the way of joints that a torque drives."""

import numpy as np
from numpy.typing import NDArray

from stillarm.benchmarks.identification_data import Pair
from stillarm.diagnosis.driven.foretold import foretold, identified_on
from stillarm.diagnosis.driven.recording.signals import Driven, Kind, Output, counter_step

Array = NDArray[np.float64]

_BUDGET_S = 60.0  # the default of `stillarm diagnose`


def as_driven(pair: Pair) -> tuple[Array, str]:
    """Identified on the samples that are fitted; then one free run over the others."""
    result = identified_on(read_pair(pair, pair.train), _BUDGET_S)
    final, verdict = result.verdict.final, result.verdict
    (shown,) = foretold(final, read_pair(pair, pair.test)).values()
    said = ", ".join(one.form.cause for one in verdict.findings) or "no cause"
    return shown, f"{verdict.verdict}: {said}; linear, with {final.box.modes} modes"


def read_pair(pair: Pair, span: slice) -> Driven:
    """Some samples of a pair, as of a torque of unknown unit and of what it bends or accelerates."""
    kind: Kind = "acceleration" if pair.accelerates else "deflection"
    name = "acceleration_m_s2" if pair.accelerates else "deflection_m"
    seen = Output(name, kind, pair.y[span], False, counter_step(pair.y))
    step_s = 1.0 / pair.rate_hz
    return Driven(pair.name, step_s, 0.0, "joint_torque_command_n_m", pair.u[span], False, (seen,), {})
