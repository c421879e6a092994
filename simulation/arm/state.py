"""The stepper's state: one record with the joint and its drive, the modes, the laws of causes, and work space.

It is a record, because compiled code reaches its fields by name at no cost, and one pointer passes all of them.
"""

from math import floor, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Drive
from stillarm.common.user_error import UserError

Array = NDArray[np.float64]
Records = NDArray[np.void]
Record = Any
"""In compiled code: a pointer to the first of some records."""

MOST_MODES, MOST_LAWS = 32, 32
# two holds of a cycle, each with a limit, two stops, and a turn and a contact of the play in each
MOST_STRETCHES = 64

STEP = np.dtype(
    [
        ("h", "f8"),  # a duration, s; 0: none yet
        ("fade", "f8"),  # what is left after half of it of a theta'' that decays with the drive's lag
        ("a", "f8"),  # transition of a free mode's (q, v) over half of it: [[a, b], [c, d]]
        ("b", "f8"),
        ("c", "f8"),
        ("d", "f8"),
        ("wa", "f8"),  # and over the whole
        ("wb", "f8"),
        ("wc", "f8"),
        ("wd", "f8"),
    ],
    align=True,
)
MODE = np.dtype(
    [
        ("hz", "f8"),  # as declared
        ("zeta", "f8"),
        ("push", "f8"),  # participation times length, m
        ("q", "f8"),  # deflection at the tip, m
        ("v", "f8"),  # its rate, m/s
        ("force", "f8"),  # acceleration held over a cycle: a disturbance, m/s^2
        ("w", "f8"),  # angular frequency that the rest is tuned to, rad/s
        ("sigma", "f8"),  # zeta w
        ("damped", "f8"),  # w sqrt(1 - zeta^2)
        ("stiffness", "f8"),  # w^2
        ("static", "f8"),  # how q follows a constant theta'', m s^2
        ("lagged", "f8"),  # and one that decays with the drive's lag
        ("one", STEP),  # the two durations that a cycle usually asks for
        ("other", STEP),
        ("replaced", "i8"),  # which of them comes next
    ],
    align=True,
)
LAW = np.dtype(
    [
        ("address", "i8"),
        ("site", "i8"),  # FORCE, FRICTION or FREQUENCY
        ("count", "i8"),  # how many numbers of its own
        ("corner", "i8"),  # whether it has one where the first mode turns
        ("foreign", "i8"),  # whether it follows from time and joint alone
        ("begin", "f8"),  # instant from which it acts, s
        ("onset", "f8"),  # instant at which it breaks off, s; infinite where it does not
        ("n0", "f8"),
        ("n1", "f8"),
        ("n2", "f8"),
        ("n3", "f8"),
    ],
    align=True,
)
STRETCH = np.dtype(
    [
        ("duration", "f8"),  # s; the link's theta'' = start exp(-decay t)
        ("decay", "f8"),  # 1/s
        ("start", "f8"),  # rad/s^2
        ("end", "f8"),  # theta'' at its end
        ("jump", "f8"),  # of theta' at its end, an impact, rad/s
        ("theta", "f8"),  # at its start, rad
        ("omega", "f8"),  # rad/s
    ],
    align=True,
)
ARM = np.dtype(
    [
        ("decay", "f8"),  # 2 pi bandwidth, 1/s
        ("most", "f8"),  # limit of acceleration, rad/s^2
        ("lowest", "f8"),  # end stops, rad
        ("highest", "f8"),
        ("gap", "f8"),  # play between motor and link, rad
        ("early", "f8"),  # part of a cycle, s, in which the command before still acts
        ("late", "f8"),  # the rest of it
        ("early_risen", "f8"),  # integrals of exp(-decay t) over them, s
        ("late_risen", "f8"),
        ("turn", "f8"),  # the most by which the first mode may turn in one step of the laws, rad
        ("motor", "f8"),  # angle, rad
        ("rate", "f8"),  # of the motor, rad/s
        ("acceleration", "f8"),  # of the motor, rad/s^2
        ("ahead", "f8"),  # motor's angle less the link's, rad
        ("contact", "f8"),  # 1 where motor and link move together across the play
        ("modes", "i8"),  # how many there are
        ("laws", "i8"),
        ("pushes", "i8"),  # whether a law pushes or rubs on the first mode
        ("foreign", "i8"),  # whether all laws that do so are foreign
        ("changes", "i8"),  # whether a law changes frequencies
        ("turns", "i8"),  # whether steps are to end where the first mode turns
        # a further acceleration of the first mode, c0 + c1 x + c2 x^2 with x in s from the cycle's start
        ("c0", "f8"),
        ("c1", "f8"),
        ("c2", "f8"),
        ("mode", MODE),  # the first of them; `nth` gives the others
        ("further_modes", MODE, (MOST_MODES - 1,)),
        ("law", LAW),
        ("further_laws", LAW, (MOST_LAWS - 1,)),
        ("stretch", STRETCH),  # of the cycle at hand
        ("further_stretches", STRETCH, (MOST_STRETCHES - 1,)),
    ],
    align=True,
)
FORCE, FRICTION, FREQUENCY = 0, 1, 2
FINE_TURN = 0.0085
"""Of the first mode in a step of the laws, rad: their error is then below 1e-9 of the amplitude."""


def make_arm(
    drive: Drive,
    cycle_s: float,
    modes: Array,
    laws: Records,
    gap_rad: float = 0.0,
    turn_rad: float = FINE_TURN,
) -> tuple[Records, int]:
    """An arm at rest at joint position zero, or at the end stop nearest to it, (1,); and how many whole cycles a
    command comes later than it was issued.

    modes: (m, 3) frequency, Hz, damping ratio, participation times length, m. turn_rad: the most by which the first
    mode may turn in one step of the laws. Raises UserError for more modes or laws than there is room for.
    """
    if len(modes) > MOST_MODES or len(laws) > MOST_LAWS:
        raise UserError(
            f"effects: {len(modes)} bending modes and {len(laws)} laws act in the arm; at most {MOST_MODES} and "
            f"{MOST_LAWS} can: remove some"
        )
    cycles = drive.dead_time_s / cycle_s
    whole = floor(cycles + 1e-9)
    rest = cycles - whole
    arm = np.zeros(1, ARM)
    arm["decay"] = decay = 2.0 * pi * drive.bandwidth_hz
    arm["most"] = drive.max_acceleration_rad_s2
    arm["lowest"], arm["highest"] = drive.min_position_rad, drive.max_position_rad
    arm["gap"], arm["turn"] = gap_rad, turn_rad
    arm["early"] = early = rest * cycle_s if rest > 1e-9 else 0.0
    arm["late"] = cycle_s - early
    for part in ("early", "late"):
        arm[f"{part}_risen"] = -np.expm1(-decay * arm[part]) / decay
    arm["motor"] = min(max(0.0, drive.min_position_rad), drive.max_position_rad)
    arm["modes"], arm["laws"] = len(modes), len(laws)
    arm["changes"] = np.any(laws["site"] == FREQUENCY)
    # the corner of a force, v |v| say, adds less than a coarse step's own error
    arm["turns"] = np.any((laws["site"] == FRICTION) | ((laws["corner"] != 0) & (turn_rad <= FINE_TURN)))
    arm["pushes"] = np.any(laws["site"] != FREQUENCY)
    arm["foreign"] = np.all((laws["site"] == FREQUENCY) | ((laws["site"] == FORCE) & (laws["foreign"] != 0)))
    room = modes_of(arm)
    room["hz"], room["zeta"], room["push"] = np.reshape(modes, (-1, 3)).T
    _several(arm, "law", LAW)[: len(laws)] = laws
    return arm, whole


def modes_of(arm: Records) -> Records:
    """The arm's modes, (m,), as a view."""
    return _several(arm, "mode", MODE)[: int(arm["modes"][0])]


def _several(arm: Records, first: str, kind: np.dtype[np.void]) -> Records:
    """All that there is room for of what begins with a field, as a view."""
    assert arm.dtype.fields is not None
    count = {"mode": MOST_MODES, "law": MOST_LAWS}[first]
    return np.ndarray((count,), kind, arm, arm.dtype.fields[first][1])
