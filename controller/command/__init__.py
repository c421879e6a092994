"""From an estimate to a joint velocity: damping, shaping of the external reference, dither, limits.

Not here: whether the joint may move at all (controller/safety). Begin with damping.py, then limits.py.
"""

__all__ = ["damping", "dither", "limits", "motion"]
