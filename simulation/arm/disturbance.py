"""External disturbances of a scenario: strikes at given times, and white noise on every mode."""

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from stillarm.common.files.scenario import Scenario, Strike
from stillarm.common.user_error import UserError

if TYPE_CHECKING:
    from stillarm.simulation.arm.plant import Plant

DISTURBANCE_STREAM = 2  # of the seed's random streams
_BLOCK = 1024  # numbers are cheap to draw by the thousand, and dear one by one
_REFERENCE_PERIOD_S = 0.001  # random_disturbance_m_s2 is stated for a sample at 1 kHz


class Disturbance:
    """A scenario's strikes and random disturbance, cycle by cycle; deterministic from the generator's seed.

    The white acceleration is held over a cycle and has standard deviation level * sqrt(1 ms / cycle), so
    that its spectral density does not depend on the cycle. A strike falls on the first cycle at or after its
    time.
    """

    def __init__(
        self,
        scenario: Scenario,
        modes: int,
        cycle_s: float,
        generator: np.random.Generator,
        name: str = "scenario",
    ) -> None:
        """modes: how many the arm has. `name` stands for the scenario's file in messages.

        Raises UserError for a strike on a mode that the arm does not have.
        """
        for index, strike in enumerate(scenario.strikes):
            if strike.mode > modes:
                raise UserError(
                    f"{name}: strikes[{index}].mode = {strike.mode}: the arm has modes 1 to {modes}; "
                    "choose one of them, or add [[arm.modes]] to the model"
                )
        self._strikes = sorted(scenario.strikes, key=lambda strike: strike.time_s, reverse=True)
        self._std = scenario.random_disturbance_m_s2 * sqrt(_REFERENCE_PERIOD_S / cycle_s)
        self._modes = modes
        self._generator = generator
        self._block: list[list[float]] = []
        self._still = [0.0] * modes

    def strikes_until(self, time_s: float) -> list[Strike]:
        """The strikes that have fallen due at `time_s`, in order; each is returned once."""
        due: list[Strike] = []
        while self._strikes and self._strikes[-1].time_s <= time_s + 1e-9:  # cycle * cycle_s is rounded
            due.append(self._strikes.pop())
        return due

    def forces_m_s2(self) -> list[float]:
        """Acceleration of each mode over the next cycle, m/s^2: fresh white noise at every call."""
        if self._std == 0.0:
            return self._still
        if not self._block:
            drawn = self._generator.standard_normal((_BLOCK, self._modes)) * self._std
            self._block = drawn[::-1].tolist()
        return self._block.pop()

    def act_on(self, plant: "Plant", time_s: float) -> list[Strike]:
        """Shake the plant as is due for the cycle that begins at `time_s`; call it before each advance().

        Returns the strikes that fell.
        """
        fallen = self.strikes_until(time_s)
        for strike in fallen:
            plant.strike(strike.mode, strike.deflection_m)
        plant.modal_forces_m_s2 = self.forces_m_s2()
        return fallen
