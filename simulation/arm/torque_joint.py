"""A joint that is driven by a torque, with the arm's modes coupled to it: the equations of motion, compiled.

All torques are divided by the joint's immediate inertia J_hub: that of the hub, the gear and the motor, without the
modes' part. u is the input: a torque, a current, or a voltage behind a motor whose back EMF is part of d.

    theta'' = gain u - d theta' - k theta + f(t, theta, theta') + sum_i pull_i (2 zeta_i w_i q_i' + w_i^2 q_i)
    q_i''   = - 2 zeta_i w_i q_i' - w_i^2 q_i - b_i theta'' (+ force on q_1)

w_i are the clamped-free frequencies: those of the arm while the hub is held (locked). A free hub vibrates with it at
higher ones, w_i sqrt(1 + pull_i b_i) for a single mode: that is the hinged-free arm with its hub (Cannon and Schmitz,
Int. J. Robotics Research 3, 1984). b_i = participation_i * length; pull_i b_i = (modal inertia about the
joint) / J_hub.

The linear part is solved exactly over a step, u being linear in it (first-order hold). Dry friction is the force that
lets the velocity at the end of the step be zero, as far as its limit allows: Moreau's time stepping, which slides,
sticks and breaks loose without a search for the instant (Moreau, Unilateral contact and dry friction, 1988). Other
laws act at the step's middle, as extrapolated. Errors are of second order in the step, of first where the joint turns.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

from stillarm.simulation.arm.compiler import compiled, inlined

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

LAWS = (
    "coulomb_positive",  # of the friction while the joint turns forward, as acceleration, rad/s^2
    "coulomb_negative",  # and backward
    "stribeck_positive",  # by how much friction is larger at rest
    "stribeck_negative",
    "stribeck_velocity",  # at which that has fallen to 1/e, rad/s
    "viscous_square",  # c theta' |theta'|, 1/rad
    "viscous_asymmetry",  # c |theta'|, 1/s
    "ripple_sine",  # sine and cosine of `ripple_cycles` a radian, rad/s^2
    "ripple_cosine",
    "ripple_cycles",
    "gravity_sine",  # sine and cosine of theta, rad/s^2
    "gravity_cosine",
    "offset",  # rad/s^2
    "stiffness_cubic",  # c theta^3, 1/(rad^2 s^2)
    "arm_cubic",  # c q_1^3
    "arm_coulomb",  # dry friction on q_1'
)
"""What `torque_run` obeys beside the linear equations, in the order of its numbers; zero is off."""
CP, CN, SP, SN, SV, V2, VA, RS, RC, RN, GS, GC, OFF, K3, Q3, QC = range(len(LAWS))
"""Their places in it."""
TINY = 1e-12
"""rad/s, below which friction that is larger at rest has no velocity over which it fades."""
_TERMS = 14  # of a matrix of norm 1/4: 1/14! (1/4)^14 is below 1e-19


def laws_of(numbers: Mapping[str, float]) -> Array:
    """The numbers of LAWS, (l,), from those that causes are stated by (stillarm.common.causes.driven).

    Those tell friction by its mean over both directions and half the difference.
    """
    law = {name: numbers.get(name, 0.0) for name in LAWS}
    mean, half = numbers.get("coulomb", 0.0), numbers.get("coulomb_difference", 0.0)
    law["arm_cubic"] += numbers.get("arm_cubic_over_w2", 0.0) * exp(2.0 * numbers.get("log_w_1", 0.0))
    # a turn of the joint is no turn of the angle that is measured: a wave in the place of a ripple's
    if numbers.get("gravity_cycles", 0.0) > 0.0:
        law["ripple_sine"], law["gravity_sine"] = law["gravity_sine"], 0.0
        law["ripple_cosine"], law["gravity_cosine"] = law["gravity_cosine"], 0.0
        law["ripple_cycles"] = numbers["gravity_cycles"]
    law["coulomb_positive"], law["coulomb_negative"] = max(mean + half, 0.0), max(mean - half, 0.0)
    law["stribeck_positive"] = law["stribeck_negative"] = numbers.get("stribeck", 0.0)
    law["stribeck_velocity"] = exp(min(numbers.get("log_stribeck_velocity", 0.0), 10.0))
    return np.array(list(law.values()))


@dataclass(frozen=True)
class LinearJoint:
    """The linear part. gain: rad/s^2 per unit of u; damping d, 1/s; stiffness k, 1/s^2.

    modes: (m, 4) clamped-free angular frequency w, rad/s, damping ratio, b, m, and pull, 1/m. State: theta, theta',
    then q_i, q_i' of each mode.
    """

    gain: float
    damping: float = 0.0
    stiffness: float = 0.0
    modes: tuple[tuple[float, float, float, float], ...] = ()

    def equations(self) -> tuple[Array, Array]:
        """A (n, n) and B (n, 3) of z' = A z + B (u, force on the joint, force on the first mode), SI."""
        n = 2 + 2 * len(self.modes)
        a, b = np.zeros((n, n)), np.zeros((n, 3))
        a[0, 1] = 1.0
        a[1, 0], a[1, 1] = -self.stiffness, -self.damping
        b[1, 0], b[1, 1] = self.gain, 1.0
        for i, (w, zeta, _, pull) in enumerate(self.modes):
            a[1, 2 + 2 * i], a[1, 3 + 2 * i] = pull * w * w, pull * 2.0 * zeta * w
        for i, (w, zeta, follows, _) in enumerate(self.modes):
            q, v = 2 + 2 * i, 3 + 2 * i
            a[q, v] = 1.0
            a[v] = -follows * a[1]
            b[v] = -follows * b[1]
            a[v, q] -= w * w
            a[v, v] -= 2.0 * zeta * w
        if self.modes:
            b[3, 2] = 1.0
        return a, b


def transition(linear: LinearJoint, step_s: float) -> tuple[Array, Array]:
    """Over a step: Phi (n, n), and G (n, 4) for u at its start and its end, and the two forces held.

    Van Loan, IEEE Trans. Automatic Control 23, 1978.
    """
    a, b = linear.equations()
    n = len(a)
    large = np.zeros((n + 4, n + 4))
    large[:n, :n] = a * step_s
    large[:n, n : n + 3] = b * step_s
    large[n, n + 3] = 1.0  # u' over the step
    moved = exponential(large)
    g = np.empty((n, 4))
    g[:, 1] = moved[:n, n + 3]
    g[:, 0] = moved[:n, n] - g[:, 1]
    g[:, 2:] = moved[:n, n + 1 : n + 3]
    return moved[:n, :n], g


@compiled
def exponential(matrix: Array) -> Array:
    """exp of a small matrix: Taylor's series of a part that is small enough, squared back (to rounding errors)."""
    size = np.max(np.sum(np.abs(matrix), axis=1))
    halvings = max(0, int(np.ceil(np.log2(max(size, 1e-300)))) + 2)
    part = matrix / 2.0**halvings
    term = np.eye(len(matrix))
    total = term.copy()
    for k in range(1, _TERMS):
        term = term @ part / k
        total += term
    for _ in range(halvings):
        total = total @ total
    return total


@inlined
def friction_limits(laws: Array, omega: float) -> tuple[float, float]:
    """The largest dry friction against forward and against backward motion, rad/s^2."""
    fade = 0.0
    if laws[SV] > TINY and (laws[SP] != 0.0 or laws[SN] != 0.0):
        ratio = omega / laws[SV]
        fade = np.exp(-ratio * ratio)
    return max(laws[CP] + laws[SP] * fade, 0.0), max(laws[CN] + laws[SN] * fade, 0.0)


@inlined
def smooth_torque(laws: Array, theta: float, omega: float) -> float:
    """Sum of the laws that act on the joint, without dry friction, rad/s^2."""
    phase = laws[RN] * theta
    torque: float = (
        laws[OFF]
        - (laws[V2] * omega + laws[VA]) * abs(omega)
        + laws[RS] * np.sin(phase)
        + laws[RC] * np.cos(phase)
        + laws[GS] * np.sin(theta)
        + laws[GC] * np.cos(theta)
        - laws[K3] * theta * theta * theta
    )
    return torque


@compiled
def torque_run(  # noqa: PLR0912 (in one loop, as each call inside it would cost as much as its body)
    phi: Array, g: Array, laws: Array, switch: int, u: Array, substeps: int, step_s: float,
    starts: Integers, states: Array, out: Array, out_force: Array,
) -> None:  # fmt: skip
    """Free runs over the segments of a recording, one after the other.

    phi: (2, n, n) and g: (2, n, 4) of a substep (`transition`), before sample `switch` and from it on. laws: (2, l),
    likewise. u: (samples * substeps, 2) at each substep's start and end. starts: (segments + 1,) first
    sample of each, and the end; states: (segments, n) there. Fills out (samples, n) at each sample, and
    out_force (samples, 2): the forces on the joint and on the first mode just after it, rad/s^2, m/s^2.
    """
    n = phi.shape[1]
    z, new = np.empty(n), np.empty(n)
    for segment in range(len(starts) - 1):
        z[:] = states[segment]
        for k in range(starts[segment], starts[segment + 1]):
            part = 1 if k >= switch else 0
            f, law = phi[part], laws[part]
            for i in range(n):
                out[k, i] = z[i]
            for s in range(substeps):
                at = k * substeps + s
                omega = z[1]
                push = smooth_torque(law, z[0] + 0.5 * step_s * omega, omega)
                force = 0.0
                if n > 2:
                    middle = z[2] + 0.5 * step_s * z[3]
                    force = -law[Q3] * middle * middle * middle
                for i in range(n):
                    total = g[part, i, 0] * u[at, 0] + g[part, i, 1] * u[at, 1] + g[part, i, 2] * push
                    total += g[part, i, 3] * force
                    for j in range(n):
                        total += f[i, j] * z[j]
                    new[i] = total
                forward, backward = friction_limits(law, omega)
                rub, rub_arm = 0.0, 0.0
                if forward > 0.0 or backward > 0.0:
                    rub = min(max(-new[1] / g[part, 1, 2], -forward), backward)
                    for i in range(n):
                        new[i] += g[part, i, 2] * rub
                if n > 2 and law[QC] > 0.0:
                    rub_arm = min(max(-new[3] / g[part, 3, 3], -law[QC]), law[QC])
                    for i in range(n):
                        new[i] += g[part, i, 3] * rub_arm
                if s == 0:
                    out_force[k, 0], out_force[k, 1] = push + rub, force + rub_arm
                for i in range(n):
                    z[i] = new[i]
