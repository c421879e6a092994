"""The stepper against scipy's solve_ivp, with each law that the catalogue has for the arm and its drive."""

from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stillarm.common.causes import CAUSES
from stillarm.common.files.effects import acting
from stillarm.common.files.model import Arm, Drive, Mode, Model
from stillarm.simulation.arm.plant import Plant

Array = NDArray[np.float64]

CYCLE_S, LENGTH_M, STRIKE_M = 0.001, 2.0, 0.012
MODES = [Mode(), Mode(frequency_hz=16.3, damping_ratio=0.02, participation=-0.14)]
DRIVE = Drive(dead_time_s=0.0023, max_velocity_rad_s=10.0, max_acceleration_rad_s2=1e4)
COMMANDS = np.repeat([0.0, 0.08, -0.05, 0.02, 0.0], [250, 150, 150, 150, 500])
EXACT = {"rtol": 1e-12, "atol": 1e-15, "method": "DOP853"}
LAWS = [name for name, cause in CAUSES.items() if cause.acts in ("force", "friction", "frequency", "command")]


def effect_of(identifier: str) -> dict[str, Any]:
    """Of the largest size that is usual; with an onset within the run, off the grid of cycles."""
    effect: dict[str, Any] = {"cause": identifier}
    for one in CAUSES[identifier].parameters:
        if one.default is None:
            effect[one.name] = one.typical[1] + (one.neutral if one.neutral == one.neutral else 0.0)
        if one.name == "onset_s":
            effect[one.name] = 0.45037
    return effect


class Judge:
    """The contract's equations with the laws as the catalogue has them, restarted wherever anything breaks off."""

    def __init__(self, model: Model) -> None:
        self.lag = 2.0 * pi * model.drive.bandwidth_hz
        self.laws = [(CAUSES[name], CAUSES[name].arguments(values)) for name, values in acting(model)]
        self.onsets = [values["onset_s"] for _, values in acting(model) if "onset_s" in values]
        self.shift_s = 0.0  # towards the inside of the span: a law jumps at its onset

    def of(self, site: str, *given: float) -> list[float]:
        return [cause.law(*given, *own) for cause, own in self.laws if cause.acts == site and cause.law]

    def target(self, time: float) -> float:
        place = int(np.floor((time - DRIVE.dead_time_s) / CYCLE_S + 1e-6))
        command = float(COMMANDS[place]) if place >= 0 else 0.0
        for cause, own in self.laws:
            if cause.acts == "command" and cause.law:
                command = cause.law(command, *own)
        return command

    def free(self, t: float, x: Array, target: float) -> tuple[list[float], float]:
        """The state's rates without friction, and the largest friction."""
        theta, omega, q1, v1, q2, v2 = x
        alpha = self.lag * (target - omega)
        w = []
        for i, mode in enumerate(MODES):
            ratio = np.prod(self.of("frequency", t + self.shift_s, float(i), MODES[0].frequency_hz))
            w.append(2.0 * pi * mode.frequency_hz * ratio)
        state = (t, theta, omega, q1, v1, w[0])
        pulls = [
            -(w[i] ** 2) * q
            - 2.0 * MODES[i].damping_ratio * w[i] * v
            - MODES[i].participation * LENGTH_M * alpha
            for i, (q, v) in enumerate(((q1, v1), (q2, v2)))
        ]
        return [omega, alpha, v1, pulls[0] + sum(self.of("force", *state)), v2, pulls[1]], sum(
            self.of("friction", *state)
        )

    def run(self) -> Array:
        """(theta, theta', q1, q1', q2, q2') at each cycle, from an impact on the first mode on."""
        times = np.arange(len(COMMANDS) + 1) * CYCLE_S
        changes = np.flatnonzero(np.diff(COMMANDS, prepend=0.0)) * CYCLE_S + DRIVE.dead_time_s
        edges = np.unique([0.0, *changes[changes < times[-1]], *self.onsets, times[-1]])
        rows = np.empty((len(times), 6))
        x = np.array([0.0, 0.0, 0.0, 2.0 * pi * MODES[0].frequency_hz * STRIKE_M, 0.0, 0.0])
        for begin, end in pairwise(edges):
            x = self._through(begin, end, x, self.target(0.5 * (begin + end)), times, rows)
        rows[-1] = x
        return rows

    def _through(self, begin: float, end: float, x: Array, target: float, times: Array, rows: Array) -> Array:
        self.shift_s = 1e-12 if begin in self.onsets else -1e-12 if end in self.onsets else 0.0
        while begin < end:
            rates, rub = self.free(begin, x, target)
            holds = bool(x[3] == 0.0 and abs(rates[3]) <= rub)
            direction = 0.0 if holds else float(np.sign(x[3] or rates[3]))

            def slope(t: float, y: Array, holds: bool = holds, direction: float = direction) -> list[float]:
                rates, rub = self.free(t, y, target)
                rates[3] = 0.0 if holds else rates[3] - direction * rub
                return rates

            def turns(t: float, y: Array, holds: bool = holds, direction: float = direction) -> float:
                rates, rub = self.free(t, y, target)
                return rub - abs(rates[3]) if holds else direction * float(y[3])

            turns.terminal, turns.direction = True, -1.0  # type: ignore[attr-defined]
            found = solve_ivp(slope, (begin, end), x, events=turns, dense_output=True, max_step=0.02, **EXACT)
            until = float(found.t[-1])
            inside = (times >= begin - 1e-12) & (times < until)
            rows[inside] = found.sol(np.clip(times[inside], begin, until)).T
            x = found.y[:, -1].copy()
            if found.status == 1 and not holds:
                x[3] = 0.0
            begin = until
        return x


@pytest.mark.slow
@pytest.mark.parametrize("identifier", [None, *LAWS])
def test_every_law_moves_the_arm_as_scipy_says(identifier: str | None) -> None:
    """To 1e-9 of each quantity's range."""
    effects = [] if identifier is None else [effect_of(identifier)]
    model = Model(arm=Arm(length_m=LENGTH_M, modes=MODES), drive=DRIVE, effects=effects)
    plant = Plant(model)
    plant.strike(1, STRIKE_M)
    rows = []
    for command in [None, *COMMANDS.tolist()]:
        if command is not None:
            plant.advance(command)
        pairs = zip(plant.modal_deflections_m, plant.modal_rates_m_s, strict=True)
        rows.append(
            [plant.joint_position_rad, plant.joint_velocity_rad_s, *(x for pair in pairs for x in pair)]
        )
    wanted = Judge(model).run()
    off = np.max(np.abs(np.array(rows) - wanted), axis=0) / np.max(np.abs(wanted), axis=0)
    assert np.max(off) < 1e-9
