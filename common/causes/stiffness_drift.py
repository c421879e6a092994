"""A stiffness that drifts."""

from stillarm.common.causes.declaration import OTHERS, Cause, size

_LEAST = 0.01  # of the declared frequency: an arm that has lost its stiffness is no longer one


def law(
    t: float, mode: float, first_hz: float, frequency_rate_hz_per_s: float, higher_modes_share: float
) -> float:
    """A mode's frequency over the declared one."""
    share = 1.0 if mode == 0.0 else higher_modes_share
    return 1.0 + share * frequency_rate_hz_per_s / first_hz * t


def limit(
    t: float, first_hz: float, q: float, frequency_rate_hz_per_s: float, higher_modes_share: float
) -> str | None:
    """What to say when the drift has taken the stiffness away."""
    if 1.0 + frequency_rate_hz_per_s / first_hz * t >= _LEAST:
        return None
    return (
        f"at {t:.3f} s nothing is left of the arm's stiffness; take a smaller frequency_rate_hz_per_s, "
        "or a shorter run"
    )


CAUSE = Cause(
    "stiffness_drift",
    "arm",
    name="a stiffness that drifts",
    sees="the frequency creeps up or down all along, as when the arm warms",
    equation="f_1(t) = f_1 + rate t; the other modes by share of that, in proportion",
    parameters=(
        size("frequency_rate_hz_per_s", "Hz/s", 10.0, 0.0005, 0.004, signed=True),
        OTHERS,
    ),
    provoke="strikes of the same size, spread over the whole recording, damping off.",
    acts="frequency",
    law=law,
    limit=limit,
)
