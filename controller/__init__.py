"""The controller's 1 ms cycle: estimates the capture delay, predicts the present deflection, damps it with the joint.

Begin with `step.py`, then `loop.py`. No simulation belongs here, and the daemon imports neither scipy nor numba.
"""
