"""The arm with its joint: the equations of motion, once, compiled, for the rig, `simulate`, diagnosis and benchmarks.

Everything that moves by those equations belongs here; sensors and camera do not. A cause that acts in the arm is added
by its declaration (stillarm.common.causes), not by a change here. Begin to read at stepper.py.
"""

__all__ = [
    "ahead",
    "compiled_laws",
    "compiler",
    "disturbance",
    "effect_clock",
    "free_run",
    "geared_joint",
    "plant",
    "state",
    "torque_joint",
]
