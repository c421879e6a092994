"""Laws without a name of their own: what an arm may do that no listed cause does, to be held against the listed ones.

A simulation obeys them as it does a cause's (`LAWS` of this package has both), so that a name has to win against them
on its own ground, in free run. No model file holds one, and no report names one: what it wins is unexplained.
"""

from stillarm.common.causes.declaration import Cause, Parameter, size


def one_sided(
    t: float, theta: float, omega: float, q: float, v: float, w: float, share: float, at_m: float
) -> float:
    """Acceleration of the first mode, m/s^2: a stiffness that is another beyond a deflection to one side."""
    over = max(q - at_m, 0.0) if at_m >= 0.0 else min(q - at_m, 0.0)
    return -share * w * w * over


RIVALS = {
    one.identifier: one
    for one in (
        Cause(
            "one_sided_stiffness",
            "arm",
            name="a force that is not the same to both sides",
            sees="the arm is stiffer, or softer, beyond a deflection to one side",
            equation="q_1'' = ... - w_1^2 share (q_1 - at)  where q_1 > at >= 0, or q_1 < at < 0",
            parameters=(
                size("share", "1", 1e4, 0.01, 1.0, signed=True),
                Parameter("at_m", "m", -1e3, 1e3, (1e-3, 0.1)),
            ),
            provoke="bend the arm slowly as far to one side as to the other, and measure the force.",
            acts="force",
            law=one_sided,
        ),
    )
}
