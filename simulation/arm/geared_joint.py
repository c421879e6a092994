"""A motor, play in its gear, and a link with the arm's modes: the equations of motion, compiled.

    share theta_m'' = gain u - d theta_m' + f(theta_m, theta_m') - c
    (1 - share) theta'' = c + sum_i pull_i (2 zeta_i w_i q_i' + w_i^2 q_i)

over the inertia J_hub of motor and hub together, as in stillarm.simulation.arm.torque_joint. c >= 0 acts where
theta_m - theta = gap / 2, c <= 0 at - gap / 2: it lets them part, at the step's end, at `bounce` times the velocity
at which they met (Newton's law of impact in Moreau's time stepping, 1988); 0 where the teeth give way without return.
share: of the motor in J_hub, 0 to 1. Friction and all other laws act on the motor.
"""

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiler import compiled
from stillarm.simulation.arm.torque_joint import LinearJoint, friction_limits, smooth_torque

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


def link_of(whole: LinearJoint, share: float) -> LinearJoint:
    """The link by itself, with its modes; the force of `transition` on it is c / (1 - share)."""
    modes = tuple((w, zeta, follows, pull / (1.0 - share)) for w, zeta, follows, pull in whole.modes)
    return LinearJoint(0.0, 0.0, 0.0, modes)


@compiled
def play_run(
    share: float, gain: float, damping: float, gap: float, bounce: float, laws: Array, phi: Array, g: Array, u: Array,
    substeps: int, step_s: float, starts: Integers, states: Array, out: Array, out_contact: Array,
) -> None:  # fmt: skip
    """Free runs over the segments of a recording, as `torque_run`.

    phi: (n, n), g: (n,) of the link over a substep, for its state and a force held. states: (segments, n + 2), the
    link's and theta_m, theta_m'. Fills out (samples, n + 2), and out_contact (samples,): c / (1 - share) just after.
    """
    h, n = step_s, len(g)
    z, new = np.empty(n), np.empty(n)
    yields, light = g[1] / (1.0 - share), h / share  # of link and motor, to c over a step
    for segment in range(len(starts) - 1):
        z[:] = states[segment, :n]
        motor, rate = states[segment, n], states[segment, n + 1]
        for k in range(starts[segment], starts[segment + 1]):
            out[k, :n] = z
            out[k, n], out[k, n + 1] = motor, rate
            for s in range(substeps):
                at = k * substeps + s
                push = 0.5 * gain * (u[at, 0] + u[at, 1]) - damping * rate
                push += smooth_torque(laws, motor + 0.5 * h * rate, rate)
                forward, backward = friction_limits(laws, rate)
                for i in range(n):
                    total = 0.0
                    for j in range(n):
                        total += phi[i, j] * z[j]
                    new[i] = total
                pushed = rate + light * push
                contact = 0.0
                meets = rate - z[1]
                ahead = motor - z[0] + h * meets
                if ahead >= 0.5 * gap or ahead <= -0.5 * gap:
                    parts = bounce * (max(meets, 0.0) if ahead > 0.0 else min(meets, 0.0))
                    rub = min(max(-pushed / light - new[1] / yields, -forward), backward)
                    contact = (pushed + light * rub - new[1] + parts) / (light + yields)
                    if (ahead > 0.0) != (contact >= 0.0):  # it lets go
                        contact = 0.0
                if contact == 0.0:
                    rub = min(max(-pushed / light, -forward), backward)
                new_rate = pushed + light * (rub - contact)
                for i in range(n):
                    z[i] = new[i] + g[i] * contact / (1.0 - share)
                motor += 0.5 * h * (rate + new_rate)
                rate = new_rate
                apart = motor - z[0]
                over = abs(apart) - 0.5 * gap
                if over > 0.0:
                    z[0] += np.sign(apart) * over
                if s == 0:
                    out_contact[k] = contact / (1.0 - share)
