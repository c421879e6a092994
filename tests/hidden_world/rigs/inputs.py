"""What the equations of motion are given, before and after an effect of the arm or of the drive has changed it."""

from dataclasses import dataclass

import numpy as np

from tests.hidden_world.rigs.course import wander
from tests.hidden_world.rigs.dynamics import STATES, Laws, Q, V
from tests.hidden_world.rigs.moves import Move, command, tip_force
from tests.hidden_world.rigs.rig import FINE, STEP_S, TICK_S, Rig, Values, luck


@dataclass
class Inputs:
    """asked: as recorded, a value a cycle; obeyed: a value a step, without the dead time; late_steps: of each step,
    how many steps old the command is that is in force."""

    asked: Values
    obeyed: Values
    late_steps: Values
    force: Values
    stiff: Values
    damp: Values
    laws: Laws
    modes: Values
    start: Values

    def delayed(self) -> Values:
        """The command in force in each step, rad/s; 0 before the first."""
        index = np.arange(len(self.obeyed)) - np.round(self.late_steps).astype(int)
        return np.where(index >= 0, self.obeyed[np.maximum(index, 0)], 0.0)


def plain_inputs(rig: Rig, moves: list[Move], nuisance: bool = True) -> Inputs:
    """Of a rig with nothing hidden."""
    asked = command(moves, rig.cycles)
    modes = [*rig.modes]
    if nuisance and rig.nuisance.third:
        modes.append(rig.nuisance.third)
    rows = [[2.0 * np.pi * m.frequency_hz, m.damping_ratio, m.participation, m.push] for m in modes]
    lag = 2.0 * np.pi * rig.drive.bandwidth_hz
    most = rig.drive.max_acceleration_rad_s2
    laws = Laws(rig.length_m, lag, lag, most_up=most, most_down=most)
    damp = np.ones(rig.cycles)
    if nuisance:
        laws = laws._replace(skew=rig.nuisance.skew / max(scale_m(rig), 1e-9))
        course = wander(np.arange(rig.cycles) * TICK_S, rig.nuisance.warmth_time_s, luck(rig.seed, 23))
        damp = np.clip(1.0 + rig.nuisance.warmth * course, 0.5, 1.5)
    w = rows[0][0]
    start = np.zeros(STATES)
    start[Q] = rig.swinging_m * np.cos(rig.swinging_phase)
    start[V] = rig.swinging_m * w * np.sin(rig.swinging_phase)
    late = np.full(rig.steps, rig.drive.dead_time_s / STEP_S)
    obeyed = np.repeat(np.clip(asked, -rig.drive.max_velocity_rad_s, rig.drive.max_velocity_rad_s), FINE)
    return Inputs(
        asked,
        obeyed,
        late,
        tip_force(moves, rig.steps),
        np.ones(rig.cycles),
        damp,
        laws,
        np.array(rows),
        start,
    )


def scale_m(rig: Rig) -> float:
    """A bending that the rig's moves bring about, m."""
    mode = rig.modes[0]
    return abs(mode.participation) * rig.length_m * rig.fastest_rad_s / (2.0 * np.pi * mode.frequency_hz)
