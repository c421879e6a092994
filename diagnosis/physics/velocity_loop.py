"""A drive's velocity loop with friction, limits and further lags: the command that a plain drive would have to obey.

The stepper solves a drive that follows its command with one lag. What else a velocity loop does changes the velocity
that it reaches; the command that brings a plain drive there says the same, so that the stepper stays as it is. Over a
cycle dt, with c_k the command, late and lagged once more, e = exp(-decay dt), and e_k the same with the longer lag
that the loop has while the joint speeds up, or slows down:

    a_k = c_k - friction s_k,   s_k = sign(omega_k), at rest sign(c_k)
    omega_{k+1} = a_k + (omega_k - a_k) e_k,   then within the limits of acceleration and velocity
    c_equivalent,k = (omega_{k+1} - omega_k e) / (1 - e)

which is omega' = decay (c - friction sign(omega) - omega). A joint whose omega would change its sign stops, and at rest
it stays until |c_k| exceeds the static friction. So friction on the motion brings it to rest sooner than friction that
takes from the command. All act from an instant on.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def equivalent_command(
    command: Array,
    dt: float,
    decay: float,
    omega: float,
    begin_s: float,
    late_s: float,
    lag_s: float,
    friction: float,
    static: float,
    one_sided: float,
    most: float,
    most_up: float,
    most_down: float,
    fastest_up: float,
    fastest_down: float,
    speeding_s: float,
    slowing_s: float,
) -> Array:
    """Commands for a plain drive, rad/s, (n,), that make it move as one with all this does.

    command: (n,) rad/s. decay: 2 pi bandwidth, 1/s. omega: velocity at the start, rad/s. begin_s: from when on all the
    rest acts. late_s, lag_s: a further dead time and a further first-order lag. friction, static: while it moves and
    before it does, as the velocity that they cost, rad/s; one_sided: -1 to 1, by how much more one way than the other.
    most: limit of the acceleration, rad/s^2; most_up, most_down: one way. fastest_up, fastest_down: of the velocity,
    rad/s. speeding_s, slowing_s: by how much the lag is longer while the joint is driven and while it is braked: an
    amplifier that feeds no power back answers otherwise there.
    """
    n = len(command)
    out = np.empty(n)
    stays = np.exp(-decay * dt)
    stays_speeding, stays_slowing = (
        np.exp(-dt / (1.0 / decay + speeding_s)),
        np.exp(-dt / (1.0 / decay + slowing_s)),
    )
    follows = 1.0 - np.exp(-dt / lag_s) if lag_s > 0.0 else 1.0
    whole = int(np.floor(late_s / dt))
    part = late_s / dt - whole
    lagged = command[0]
    for k in range(n):
        aim = command[k]
        acts = k * dt >= begin_s
        if acts:
            older, newer = max(k - whole - 1, 0), max(k - whole, 0)
            aim = (1.0 - part) * command[newer] + part * command[older]
        lagged += (follows if acts else 1.0) * (aim - lagged)
        aim = lagged
        own = stays
        if acts:
            own = stays_speeding if (aim - omega) * omega >= 0.0 else stays_slowing
        if acts and (friction > 0.0 or static > 0.0):
            up, down = friction * (1.0 + one_sided), friction * (1.0 - one_sided)
            if omega == 0.0:
                holds = max(static, up if aim > 0.0 else down)
                aim = 0.0 if abs(aim) <= holds else aim - (up if aim > 0.0 else -down)
                reached = aim + (omega - aim) * own
            else:
                slowed = aim - (up if omega > 0.0 else -down)
                reached = slowed + (omega - slowed) * own
                if reached * omega < 0.0:
                    reached = 0.0
        else:
            reached = aim + (omega - aim) * own
        if acts:
            reached = min(max(reached, omega - min(most, most_down) * dt), omega + min(most, most_up) * dt)
            reached = min(max(reached, -fastest_down), fastest_up)
        out[k] = (reached - omega * stays) / (1.0 - stays)
        omega = reached
    return out
