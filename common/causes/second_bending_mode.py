"""A second bending mode."""

from stillarm.common.causes.declaration import Cause, Parameter

CAUSE = Cause(
    "second_bending_mode",
    "arm",
    name="a second bending mode",
    sees=("after a quick move or an impact the arm also rings at a higher frequency, which dies away sooner"),
    note="The image, exposed for milliseconds, shows less of it than the accelerometer.",
    equation="q_2'' + 2 zeta_2 w_2 q_2' + w_2^2 q_2 = - participation length theta''",
    parameters=(
        Parameter("frequency_hz", "Hz", 0.01, 400.0, (10.0, 25.0)),
        Parameter("damping_ratio", "1", 0.0, 0.999, (0.005, 0.03)),
        Parameter("participation", "1", -10.0, 10.0, (0.1, 0.3), signed=True),
    ),
    provoke=(
        "a short strike near the tip, or a move with a steep ramp; the accelerometer's spectrum shows "
        "the second peak."
    ),
    acts="key",
    key="arm.modes",
    repeatable=True,
)
