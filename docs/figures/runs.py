"""The simulated runs that several figures show: the paper's arm, struck, without and with damping."""

from functools import cache
from pathlib import Path

import stillarm

MODEL = Path(__file__).resolve().parents[2] / "configs" / "model.toml"


@cache
def demo_run() -> stillarm.Simulated:
    """The demo's scenario in virtual time, seed 1: struck at 2 s and rings; struck at 18 s and damped."""
    return stillarm.simulate(MODEL, "demo", 1)
