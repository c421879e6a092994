"""The simulated rig in real time, as a process that stands in for arm, accelerometer, drive and camera.

Not here: the physics (simulation/arm and its neighbours). Begin with rig.py.
"""

__all__ = ["rig", "rig_drive", "strike_requests"]
