"""When the arm is struck, and when the supervisor is killed and replaced. Times on the controller's clock, s."""

from dataclasses import dataclass

import numpy as np

from stillarm.common.files.scenario import Scenario, Strike
from stillarm.simulation.demo.set_up import STRUCK_M

FIRST_STRIKE_S = 3.0
BEFORE_KILL_S = 2.5
"""From a strike to the kill: long enough to have settled."""
AFTER_GAP_S = 4.0
"""From the first new image to the next strike."""
_PERIOD_S = 0.4
"""Kills come at any phase of the vibration, which takes about so long."""


@dataclass(frozen=True)
class Kill:
    """A kill at `at_s`, with `gap_s` asked for from the last image before it to the first one after. The arm is left
    alone until `until_s`."""

    at_s: float
    gap_s: float
    until_s: float


def plan(gaps_s: list[float], seed: int) -> tuple[list[Kill], Scenario]:
    """Each gap once, in an order of the seed's, each after a strike; the joint stays where it is."""
    luck = np.random.default_rng((seed, 71))
    strike_s, strikes, kills = FIRST_STRIKE_S, [], []
    for gap_s in luck.permutation(gaps_s).tolist():
        strikes.append(Strike(round(strike_s, 3), STRUCK_M))
        at_s = strike_s + BEFORE_KILL_S + float(luck.uniform(0.0, _PERIOD_S))
        until_s = at_s + gap_s + AFTER_GAP_S
        kills.append(Kill(at_s, gap_s, until_s))
        strike_s = until_s + 0.1
    return kills, Scenario(duration_s=round(strike_s, 3), strikes=strikes)
