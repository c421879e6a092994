"""What should have been measured: a recording's simulation in free run, as a function of one vector of quantities.

Not here: the arm's equations themselves (stillarm.simulation.arm), and fits. Begin with world.py.
"""

__all__ = [
    "ahead",
    "arm_motion",
    "camera",
    "coasting_play",
    "computing",
    "copies",
    "declared_effects",
    "linear_modes",
    "measured_joint",
    "memory",
    "quantities",
    "space",
    "window_fits",
    "world",
]
