"""A play behind which the link coasts: the command that a plain drive without play would obey to move as it does.

    motor   omega_m' = clip(decay (c - omega_m), most)
    link    omega'   = push - drag omega,   push = k (a -+ gap / 2) + d (omega_m - omega)  where a = theta_m - theta
                       is beyond +- gap / 2, as far as it pushes; 0 between the flanks

The declared play is its other end: a link with so much friction that it stands wherever nothing turns it, and teeth so
hard and dull that it keeps the motor's velocity from the first touch on. Over a cycle dt, with e = exp(-decay dt),

    c_equivalent,k = (omega_{k+1} - omega_k e) / (1 - e)

brings a plain drive to the link's velocity, as in stillarm.diagnosis.physics.velocity_loop.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SUBSTEPS = 8  # a cycle: teeth of 100 Hz turn by 0.08 rad in one of 1/8 ms


@njit(cache=True, nogil=True, error_model="numpy")
def link_velocity(
    command: Array, dt: float, decay: float, most: float, omega: float,
    gap: float, drag: float, teeth_hz: float, teeth_damping: float,
) -> Array:  # fmt: skip
    """The link's velocity at the ends of the cycles, rad/s, (n,).

    command: (n,) rad/s, as it reaches the drive. most: limit of the motor's acceleration, rad/s^2. omega: of motor and
    link at the start, the motor in the middle of the play. gap: rad. drag: 1/s. teeth_hz, teeth_damping: natural
    frequency and damping ratio of the link on its teeth.
    """
    h = dt / _SUBSTEPS
    stiffness = (2.0 * np.pi * teeth_hz) ** 2
    damping = 4.0 * np.pi * teeth_hz * teeth_damping
    half, follows = 0.5 * gap, 1.0 - np.exp(-decay * h)
    out = np.empty(len(command))
    motor, link, apart = omega, omega, 0.0
    for k in range(len(command)):
        for _ in range(_SUBSTEPS):
            rise = min(max(follows * (command[k] - motor), -most * h), most * h)
            apart += h * (motor + 0.5 * rise - link)
            motor += rise
            if apart > half:
                push = max(stiffness * (apart - half) + damping * (motor - link), 0.0)
            elif apart < -half:
                push = min(stiffness * (apart + half) + damping * (motor - link), 0.0)
            else:
                push = 0.0
            push -= drag * link
            # its place follows with the velocity after the push: symplectic, so that stiff teeth gain no energy
            apart -= h * h * push
            link += h * push
        out[k] = link
    return out


def equivalent_behind_play(
    command: Array, dt: float, decay: float, most: float, omega: float,
    gap: float, drag: float, teeth_hz: float, teeth_damping: float,
) -> Array:  # fmt: skip
    """Commands for a plain drive without play nor limit, rad/s, (n,), that move it as the link moves; arguments as of
    link_velocity."""
    reached = link_velocity(command, dt, decay, most, omega, gap, drag, teeth_hz, teeth_damping)
    stays = np.exp(-decay * dt)
    before = np.concatenate(([omega], reached[:-1]))
    found: Array = (reached - stays * before) / (1.0 - stays)
    return found
