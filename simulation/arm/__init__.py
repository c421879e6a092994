"""The arm with its joint: the equations of motion, once, compiled, for the rig, `simulate`, diagnosis and benchmarks.

Here belongs what moves by those equations; what sensors and camera make of the motion does not. A cause that acts in
the arm comes in by its declaration (stillarm.common.causes), not by a change here. Begin to read at stepper.py.
"""

__all__ = [
    "ahead",
    "compiled_laws",
    "disturbance",
    "effect_clock",
    "free_run",
    "geared_joint",
    "plant",
    "state",
    "torque_joint",
]
