"""The arm and its joint: the layout of a state, and what the known motion of the joint does to the vibration.

Not here: the estimate of the vibration, which is in filters/. Begin with layout.py.
"""

__all__ = ["joint_input", "layout"]
