"""An arm whose frequencies level off at other ones as it warms."""

import numpy as np

from stillarm.common.causes.declaration import OTHERS, Cause, Parameter, size


def law(
    t: float,
    mode: float,
    first_hz: float,
    time_constant_s: float,
    relative_change: float,
    higher_modes_share: float,
) -> float:
    """A mode's frequency over the declared one."""
    share = 1.0 if mode == 0.0 else higher_modes_share
    warmed: float = 1.0 - np.exp(-t / time_constant_s)
    return 1.0 + share * relative_change * warmed


CAUSE = Cause(
    "modal_temperature_drift",
    "arm",
    name="an arm whose frequencies level off at other ones as it warms",
    sees="the frequency creeps away from where it was, ever more slowly, and levels off",
    note="Damping ratios stay.",
    equation="f_1(t) = f_1 (1 + change (1 - exp(-t / time constant))); the other modes by share of that",
    parameters=(
        Parameter("time_constant_s", "s", 0.1, 1e6, (3.0, 30.0)),
        size("relative_change", "1", 0.5, 0.005, 0.03, signed=True),
        OTHERS,
    ),
    provoke="strikes of the same size from a cold start on, over three time constants, damping off.",
    acts="frequency",
    law=law,
    confused_with={
        "stiffness_drift": "go on recording for three time constants: a warm-up levels off, a drift goes on",
        "payload_change": "strike the arm often: a payload changes the frequency at one instant, a warm-up takes time",
    },
)
