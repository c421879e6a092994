"""Strikes of the simulated arm on request: a count in shared memory, which the panel raises and the plant follows."""

import random
from typing import TYPE_CHECKING

from stillarm.common.files.configuration import Configuration
from stillarm.common.files.scenario import Strike
from stillarm.common.memory.shared_memory import SharedBlock

if TYPE_CHECKING:
    from stillarm.simulation.arm.disturbance import Disturbance
    from stillarm.simulation.arm.plant import Plant

_DEFLECTION_M = 0.00625  # as the demo's strikes
_WORD_BYTES = 8


def strikes_name(configuration: Configuration) -> str:
    """The shared memory through which a strike is asked for."""
    return f"{configuration.camera.device}-strikes"


def request_strike(configuration: Configuration) -> None:
    """Ask the running rig for one strike. Raises UserError where no rig runs on this computer."""
    block = SharedBlock(strikes_name(configuration), create=False)
    try:
        block.buffer.cast("Q")[0] += 1
    finally:
        block.close()


class StrikesOnRequest:
    """A scenario's disturbance, and the strikes that are asked for meanwhile. Their sign is drawn."""

    def __init__(self, disturbance: "Disturbance", name: str) -> None:
        """name: of the shared memory, from strikes_name(). Raises UserError where it cannot be made."""
        self._disturbance = disturbance
        self._block = SharedBlock(name, _WORD_BYTES, create=True)
        self._asked = self._block.buffer.cast("Q")
        self._struck = 0

    def act_on(self, plant: "Plant", time_s: float) -> list[Strike]:
        """As Disturbance.act_on(); returns the requested strikes that fell, too."""
        fallen = self._disturbance.act_on(plant, time_s)
        asked = self._asked[0]
        if asked != self._struck:
            self._struck = asked
            strike = Strike(max(0.0, time_s), random.choice((-1.0, 1.0)) * _DEFLECTION_M)
            plant.strike(strike.mode, strike.deflection_m)
            fallen = [*fallen, strike]
        return fallen

    def close(self) -> None:
        """Release the memory."""
        self._asked.release()
        self._block.close()
