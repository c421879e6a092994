"""The arm and its drive in free run, compiled: the simulation that every fit and every candidate cause runs.

Equations as in docs/causes.md. Each cycle of length dt holds its command; the joint's lag and the modes are solved
exactly over it, the joint's acceleration entering the modes as its mean over the cycle; terms that depend on the
state are kicks of half a step before and after (Strang splitting, second order in the step).
"""

from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


class K(IntEnum):
    """Places in the vector of constants that `run` takes."""

    LENGTH = 0
    RATE = 1  # 2 pi bandwidth, 1/s
    DEAD_S = 2
    MAX_VELOCITY = 3
    MAX_ACCELERATION = 4
    LOWEST = 5
    HIGHEST = 6
    DEADBAND = 7
    LOSS = 8
    GAP = 9
    COULOMB = 10
    QUADRATIC = 11
    CUBIC = 12
    ONSET_S = 13
    RATIO = 14
    DRIFT = 15  # relative frequency per second
    PERIODIC_W = 16
    PERIODIC_SIN = 17
    PERIODIC_COS = 18
    THETA0 = 19
    OMEGA0 = 20
    FORCE_GAIN = 21  # of the force input on the first mode
    HIGHER = 22  # share of such a change of frequency that modes beyond the first take
    SIZE = 23


_NEAR = 0.2  # cycles between a sensor's reading and a command's arrival, at which either may come first


@njit(cache=True, nogil=True, error_model="numpy")
def _obeyed(command: float, limit: float, deadband: float, loss: float) -> float:
    c = min(max(command, -limit), limit)
    if abs(c) <= deadband:
        return 0.0
    if loss > 0.0:
        return max(c - loss, 0.0) if c > 0.0 else min(c + loss, 0.0)
    return c


@njit(cache=True, nogil=True, error_model="numpy")
def _kick(
    v: Array,
    q: Array,
    w2: Array,
    constants: Array,
    now: float,
    gain: float,
    force: Array,
    place: int,
    h: float,
) -> None:
    """Half a step of what depends on the first mode's state or on time; dry friction stops a motion, no more."""
    kick = -constants[11] * v[0] * abs(v[0]) - w2[0] * constants[12] * q[0] ** 3
    kick += constants[17] * np.sin(constants[16] * now) + constants[18] * np.cos(constants[16] * now)
    if force.size:
        kick += gain * force[place]
    v[0] += 0.5 * h * kick
    slow = 0.5 * h * constants[10]
    v[0] = v[0] - slow if v[0] > slow else (v[0] + slow if v[0] < -slow else 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _tabulate(
    table: Array, yields: Array, spans: Array, rate: float, sig: Array, wd: Array, w2: Array
) -> None:
    """What each kind of stretch turns each mode by: decay cos, decay sin; last row: what is left of theta''.

    yields: how far each mode gives way to a steady theta'' and to one that fades at `rate`, s^2, and 1 / wd.
    """
    for i in range(sig.shape[0]):
        yields[i, 0] = 1.0 / w2[i]
        yields[i, 1] = 1.0 / (rate * rate - 2.0 * sig[i] * rate + w2[i])
        yields[i, 2] = 1.0 / wd[i]
    for kind in range(spans.shape[0]):
        _turns(table, kind, spans[kind], rate, sig, wd)


@njit(cache=True, nogil=True, error_model="numpy")
def _turns(table: Array, kind: int, span: float, rate: float, sig: Array, wd: Array) -> None:
    """One row of the table."""
    for i in range(sig.shape[0]):
        decay = np.exp(-sig[i] * span)
        table[kind, i, 0] = decay * np.cos(wd[i] * span)
        table[kind, i, 1] = decay * np.sin(wd[i] * span)
        table[kind, i, 2] = np.exp(-rate * span)


@njit(cache=True, nogil=True, error_model="numpy")
def _move(
    q: Array,
    v: Array,
    i: int,
    push: float,
    sig: float,
    wd: float,
    per_wd: float,
    way: float,
    start: float,
    fade: float,
    turn_cos: float,
    turn_sin: float,
    left: float,
) -> None:
    """Mode i over one stretch, under theta'' = start exp(-fade t): its particular solution, and free about that.

    way: 1 / (fade^2 - 2 sig fade + w^2).
    """
    level = -push * start * way
    x = q[i] - level
    y = (v[i] + fade * level + sig * x) * per_wd
    a = x * turn_cos + y * turn_sin
    b = y * turn_cos - x * turn_sin
    faded = level * left if fade > 0.0 else level
    q[i] = a + faded
    v[i] = wd * b - sig * a - fade * faded


@njit(cache=True, nogil=True, error_model="numpy")
def run(  # noqa: PLR0912, PLR0915  (one loop; a call a cycle would cost as much as the cycle)
    command: Array,
    force: Array,
    dt: float,
    substeps: int,
    constants: Array,
    modes: Array,
    jump_cycles: NDArray[np.int64],
    jumps: Array,
    out_joint: Array,
    out_motor: Array,
    out_q: Array,
    out_qdd: Array,
) -> None:
    """Free run over all cycles.

    command: (n,) rad/s held over each cycle; force: (n * substeps + 1,) force input, or length 0 for none.
    modes: (m, 3) frequency_hz, damping_ratio, participation. jump_cycles: (j,) ascending; jumps: (j, m, 2) added to
    q_i and q_i' at the start of that cycle; the first is the initial state.
    Fills out_joint (n, 4): theta, theta', theta'' of the joint, and by how much theta'' jumps with a command that
    arrives near the start of the cycle (`reads_later`), less the further from it; out_motor (n, 2): of the motor; out_q
    (n, m) and out_qdd (n, m): q_i and q_i'' at the start of each cycle.
    """
    n, m = command.shape[0], modes.shape[0]
    length, rate, dead = constants[0], constants[1], constants[2]
    limit, max_acceleration = constants[3], constants[4]
    lowest, highest = constants[5], constants[6]
    deadband, loss, gap = constants[7], constants[8], constants[9]
    coulomb, quadratic, cubic = constants[10], constants[11], constants[12]
    onset, ratio, drift = constants[13], constants[14], constants[15]
    pw, ps, pc = constants[16], constants[17], constants[18]
    theta_m, omega_m = constants[19], constants[20]
    gain, higher = constants[21], constants[22]
    theta, omega, alpha, jump = theta_m, omega_m, 0.0, 0.0
    whole = int(np.floor(dead / dt + 1e-9))
    fraction = min(max(dead / dt - whole, 0.0), 1.0)
    near = max(0.0, 1.0 - min(fraction, 1.0 - fraction) / _NEAR)
    stay_early, stay_late = np.exp(-rate * fraction * dt), np.exp(-rate * (1.0 - fraction) * dt)
    # stretches of a cycle: two, where a command arrives within it, and either may see the limit of acceleration end
    starts, fades, kinds = np.zeros(4), np.zeros(4), np.zeros(4, np.int64)
    lengths = np.array(
        [fraction * dt, (1.0 - fraction) * dt, dt / substeps]
    )  # kinds of stretches; the third: a substep; those after, of any length, are tabulated as they come
    table, yields, per_rate = np.zeros((3 + len(kinds), m, 3)), np.zeros((m, 3)), 1.0 / rate
    h = dt / substeps
    nonlinear = coulomb != 0.0 or quadratic != 0.0 or cubic != 0.0 or ps != 0.0 or pc != 0.0 or force.size > 0
    q, v = np.zeros(m), np.zeros(m)
    wd, sig, w2 = np.zeros(m), np.zeros(m), np.zeros(m)
    scale_before, others_before = -1.0, -1.0
    next_jump, side, ahead = 0, 0, 0.0
    for k in range(n):
        t = k * dt
        while next_jump < jump_cycles.shape[0] and jump_cycles[next_jump] <= k:
            for i in range(m):
                q[i] += jumps[next_jump, i, 0]
                v[i] += jumps[next_jump, i, 1]
            next_jump += 1
        # relative frequency now: payload from its onset on, and drift
        blend = min(max((t + dt - onset) / dt, 0.0), 1.0)
        scale = (1.0 + (ratio - 1.0) * blend) * max(0.1, 1.0 + drift * t)
        others = max(0.1, 1.0 + higher * (ratio - 1.0) * blend) * max(0.1, 1.0 + higher * drift * t)
        if scale != scale_before or others != others_before:
            scale_before, others_before = scale, others
            for i in range(m):
                w = 2.0 * np.pi * modes[i, 0] * (others if i else scale)
                sig[i] = modes[i, 1] * w
                wd[i] = w * np.sqrt(max(1e-12, 1.0 - modes[i, 1] ** 2))
                w2[i] = w * w
            _tabulate(table, yields, lengths, rate, sig, wd, w2)
        # what the sensors see at the start of the cycle
        out_joint[k, 0], out_joint[k, 1], out_joint[k, 2], out_joint[k, 3] = theta, omega, alpha, jump
        out_motor[k, 0], out_motor[k, 1] = theta_m, omega_m
        for i in range(m):
            qdd = -2.0 * sig[i] * v[i] - w2[i] * q[i] - modes[i, 2] * length * alpha
            if i == 0 and nonlinear:
                qdd += -quadratic * v[0] * abs(v[0]) - w2[0] * cubic * q[0] ** 3
                qdd += ps * np.sin(pw * t) + pc * np.cos(pw * t)
                if force.size:
                    qdd += gain * force[k * substeps]
                # at rest dry friction holds against what pulls, as far as it goes
                qdd -= coulomb * np.sign(v[0]) if v[0] != 0.0 else min(max(qdd, -coulomb), coulomb)
            out_q[k, i] = q[i]
            out_qdd[k, i] = qdd
        # the joint over the cycle: two stretches where the dead time is no whole number of cycles
        newer, older = k - whole, k - whole - 1
        count = 0
        for half in range(2):
            if half == 0:
                if fraction <= 1e-6:
                    continue
                span, stay, index = fraction * dt, stay_early, max(older, 0)
            else:
                span, stay, index = (1.0 - fraction) * dt, stay_late, max(newer, 0)
            if span <= 0.0:
                continue
            target = _obeyed(command[index], limit, deadband, loss)
            first, before = count, omega_m
            error, kind = target - omega_m, half
            start, fade = rate * error, rate
            if abs(start) > max_acceleration:
                start, fade = (max_acceleration if start > 0.0 else -max_acceleration), 0.0
                held_s = min(abs(error) / max_acceleration - per_rate, span)
                theta_m += held_s * (omega_m + 0.5 * start * held_s)
                omega_m += start * held_s
                if held_s < span:  # the limit ends within the stretch
                    kind = 3 + count
                    _turns(table, kind, held_s, rate, sig, wd)
                    starts[count], fades[count], kinds[count] = start, fade, kind
                    count += 1
                    span, kind, fade = span - held_s, kind + 1, rate
                    _turns(table, kind, span, rate, sig, wd)
                    error, stay = target - omega_m, np.exp(-rate * span)
                    start = rate * error
            if fade > 0.0:
                theta_m += target * span - error * (1.0 - stay) * per_rate
                omega_m += error * (1.0 - stay)
            alpha_m = min(max(rate * (target - omega_m), -max_acceleration), max_acceleration)
            jump = 0.0
            if near > 0.0 and half == 1:
                other = max(newer + 1 if fraction < 0.5 else older, 0)
                if other < n:
                    beside = rate * (_obeyed(command[other], limit, deadband, loss) - omega_m)
                    beside = min(max(beside, -max_acceleration), max_acceleration)
                    jump = near * (beside - alpha_m if fraction < 0.5 else alpha_m - beside)
            if theta_m > highest or theta_m < lowest:
                theta_m = min(max(theta_m, lowest), highest)
                count, kind = first, half  # stopped over the whole stretch
                start, fade = -before / lengths[half], 0.0
                omega_m, alpha_m, jump = 0.0, 0.0, 0.0
            starts[count], fades[count], kinds[count] = start, fade, kind
            count += 1
        if gap > 0.0:
            touched, theta_before, omega_before = side, theta, omega
            theta = min(max(theta, theta_m - 0.5 * gap), theta_m + 0.5 * gap)
            ahead = 0.0
            # between the flanks the link rests; on one, it goes with the motor
            side = 1 if theta == theta_m + 0.5 * gap else -1 if theta == theta_m - 0.5 * gap else 0
            if side * omega_m > 0.0:  # the motor has just turned
                side = 0
            omega, alpha, jump = (omega_m, alpha_m, jump) if side else (0.0, 0.0, 0.0)
            if side == 0 or side != touched:
                starts[0], fades[0], kinds[0] = (omega - omega_before) / dt, 0.0, 2
                count = 1
                ahead = theta - theta_before - 0.5 * (omega_before + omega) * dt
        else:
            theta, omega, alpha = theta_m, omega_m, alpha_m
        if substeps > 1:  # a pair of input and output: no joint
            count, kinds[0], starts[0], fades[0] = 1, 2, 0.0, 0.0
        if ahead != 0.0:  # it strikes earlier in the cycle than halfway, or later
            for i in range(m):
                q[i] -= modes[i, 2] * length * ahead
        # the modes over the cycle, exactly; forces that depend on the state as kicks before and after
        for part in range(substeps):
            now = t + part * h
            if nonlinear:
                _kick(v, q, w2, constants, now, gain, force, k * substeps + part, h)
            held = 0
            if coulomb > 0.0 and v[0] == 0.0:
                pull = -w2[0] * (q[0] + cubic * q[0] ** 3) + ps * np.sin(pw * now) + pc * np.cos(pw * now)
                if force.size:
                    pull += gain * force[k * substeps + part]
                held = 1
                for j in range(count):
                    if abs(pull - modes[0, 2] * length * starts[j]) > coulomb:
                        held = 0
            for j in range(count):
                for i in range(held, m):
                    push = modes[i, 2] * length
                    c, s, left = table[kinds[j], i, 0], table[kinds[j], i, 1], table[kinds[j], i, 2]
                    way = yields[i, 1] if fades[j] > 0.0 else yields[i, 0]
                    _move(q, v, i, push, sig[i], wd[i], yields[i, 2], way, starts[j], fades[j], c, s, left)
            if nonlinear:
                _kick(v, q, w2, constants, now + h, gain, force, k * substeps + part + 1, h)


def reads_later(dead_s: float, dt: float) -> bool:
    """Whether `run` has the sensors read after a command's arrival that is near: it is just before the cycle then."""
    return bool(dead_s / dt - np.floor(dead_s / dt + 1e-9) > 0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def tip_of(
    joint: Array,
    q: Array,
    qdd: Array,
    length: float,
    slopes: Array,
    out_deflection: Array,
    out_tip: Array,
    out_acceleration: Array,
    out_angle: Array,
) -> None:
    """The tip's deflection, m, path, m, its acceleration, m/s^2, and angle, rad, from what `run` fills.

    slopes: (m,) tip's angle by the deflection of each mode, rad/m.
    """
    for k in range(joint.shape[0]):
        deflection = acceleration = angle = 0.0
        for i in range(q.shape[1]):
            deflection += q[k, i]
            acceleration += qdd[k, i]
            angle += slopes[i] * q[k, i]
        out_deflection[k] = deflection
        out_tip[k] = length * joint[k, 0] + deflection
        out_acceleration[k] = length * joint[k, 2] + acceleration
        out_angle[k] = joint[k, 0] + angle


@njit(cache=True, nogil=True, error_model="numpy")
def free_decay(frequency_hz: float, damping_ratio: float, dt: float, out: Array) -> None:
    """A free mode from q = 1, q' = 0 and from q = 0, q' = 1, at each cycle: out (n, 4): q and q'' of either."""
    w = 2.0 * np.pi * frequency_hz
    sig, wd = damping_ratio * w, w * np.sqrt(max(1e-12, 1.0 - damping_ratio**2))
    decay = np.exp(-sig * dt)
    c, s = decay * np.cos(wd * dt), decay * np.sin(wd * dt)
    x, y = 1.0, 0.0  # exp(-sig t) cos(wd t), exp(-sig t) sin(wd t)
    for k in range(out.shape[0]):
        q, v = x + sig / wd * y, -w * w / wd * y
        out[k, 0], out[k, 1] = q, -2.0 * sig * v - w * w * q
        q, v = y / wd, x - sig / wd * y
        out[k, 2], out[k, 3] = q, -2.0 * sig * v - w * w * q
        x, y = c * x - s * y, c * y + s * x


@njit(cache=True, nogil=True, error_model="numpy")
def add_decay(
    decay: Array,
    first: int,
    dq: float,
    dv: float,
    slope: float,
    q: Array,
    deflection: Array,
    tip: Array,
    acceleration: Array,
    angle: Array,
) -> None:
    """Add to a mode's q, and to what `tip_of` fills, its answer to a jump by dq and dv at cycle `first`.

    decay: (n, 4) of `free_decay`. slope: tip's angle by the mode's deflection, rad/m.
    """
    for k in range(first, q.shape[0]):
        more = dq * decay[k - first, 0] + dv * decay[k - first, 2]
        q[k] += more
        deflection[k] += more
        tip[k] += more
        angle[k] += slope * more
        acceleration[k] += dq * decay[k - first, 1] + dv * decay[k - first, 3]
