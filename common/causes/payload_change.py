"""A payload taken up or put down."""

from stillarm.common.causes.declaration import ONSET, OTHERS, Cause, Parameter


def law(
    t: float, mode: float, first_hz: float, onset_s: float, frequency_ratio: float, higher_modes_share: float
) -> float:
    """A mode's frequency over the declared one."""
    share = 1.0 if mode == 0.0 else higher_modes_share
    return 1.0 + share * (frequency_ratio - 1.0) if t.real >= onset_s.real else 1.0


CAUSE = Cause(
    "payload_change",
    "arm",
    name="a payload taken up or put down",
    sees="from an instant on the arm rings at another frequency: something was taken up or put down",
    note=(
        "Deflection, rate and damping ratio stay. How much of the first mode's change the others "
        "share depends on where the mass, or the softness, sits: none, all or more."
    ),
    equation="from onset on f_1 times ratio, f_i times 1 + share (ratio - 1)",
    parameters=(
        ONSET,
        Parameter("frequency_ratio", "1", 0.1, 10.0, (0.03, 0.15), signed=True, neutral=1.0),
        OTHERS,
    ),
    provoke="strike the arm before the change and after it.",
    acts="frequency",
    law=law,
    repeatable=True,
)
