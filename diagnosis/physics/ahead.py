"""All that a simulation of a recording calls, and the search for lost frames, compiled before a diagnosis' time counts.

Compiling takes some twenty seconds of a processor, once after an installation; loading it from disk half of one.
"""

import sys
import time

import numpy as np

from stillarm.common.causes import CAUSES, LAWS
from stillarm.common.files.model import Drive
from stillarm.diagnosis.data.lost_frames import lost_before
from stillarm.diagnosis.physics.arm_motion import OF_THE_LOOP
from stillarm.diagnosis.physics.camera import expose
from stillarm.diagnosis.physics.coasting_play import link_velocity
from stillarm.diagnosis.physics.linear_modes import add_decay, free_decay, tip_of
from stillarm.diagnosis.physics.velocity_loop import equivalent_command
from stillarm.diagnosis.physics.window_fits import swings_in_windows
from stillarm.simulation.arm.ahead import told_if_slow
from stillarm.simulation.arm.compiled_laws import address_of, laws_of, obeyed
from stillarm.simulation.arm.free_run import driven_run, free_run
from stillarm.simulation.arm.state import make_arm

_COMPILING = "compiling the simulation, once after an installation"
_CYCLES = 4  # simulated so that all is compiled: any few do
_ONE_LOST = (0.0, 1.0, 2.0, 4.0, 5.0)  # arrivals of frames, periods: one was lost, so that it is searched for
_OF_THE_STEPPER = ("force", "friction", "frequency", "command")


def compile_ahead() -> float:
    """Compile or load it; says so on standard error where that takes long. Returns the seconds that it took."""
    began_s = time.monotonic()
    with told_if_slow(_COMPILING, sys.stderr):
        for cause in LAWS.values():
            if cause.law is not None and cause.acts in _OF_THE_STEPPER:
                address_of(cause.identifier)
        _simulate_nothing()
        lost_before(np.array(_ONE_LOST), np.ones(len(_ONE_LOST) - 1, np.int64), 1.0)
    return time.monotonic() - began_s


def _simulate_nothing() -> None:
    """Call each compiled function once, with arguments of the types that a recording's simulation has."""
    n, dt = _CYCLES, 1e-3
    still = np.zeros(n)
    arm, whole = make_arm(Drive(), dt, np.array([[5.0, 0.01, 1.0]] * 2), laws_of([]))
    jumps, at = np.zeros((1, 2, 2)), np.zeros(1, np.int64)
    joint, motor, q, qdd = (np.zeros((n, width)) for width in (4, 2, 2, 2))
    free_run(arm, still, whole, at, jumps, joint, motor, q, qdd)
    driven_run(arm, np.zeros(4 * n + 1), dt, 2, at, jumps, q, qdd)
    command_law = next(cause for cause in CAUSES.values() if cause.acts == "command")
    obeyed([(command_law.identifier, {one.name: 0.1 for one in command_law.numbers})], still)
    equivalent_command(still, dt, 0.0, 0.0, 0.0, *[0.0] * len(OF_THE_LOOP))
    link_velocity(still, dt, *[1.0] * 7)
    tip = [np.zeros(n) for _ in range(4)]
    tip_of(joint, q, qdd, 1.0, np.ones(2), *tip)
    decay = np.zeros((n, 4))
    free_decay(5.0, 0.01, dt, decay)
    for mode in (q[:, 0], still):  # one of several lies apart in memory, the only one does not
        add_decay(decay, 0, 0.0, 0.0, 1.0, mode, *tip)
    expose(still, np.zeros(1), 0.0, dt, np.zeros(1), np.zeros(1))
    places, firsts, one = np.arange(n), np.array([0, n]), np.zeros(1)
    swings_in_windows(
        still, still, still, np.zeros((n, 1)), places, firsts, one, 1.0, 0.0, 0.0, np.zeros(1), one
    )
