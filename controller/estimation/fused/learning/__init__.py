"""Learning from innovations what the model does not state: how far states walk, forces, and the image scale.

Not here: faults, which are in recovery/. Begin with learnt_walks.py.
"""

__all__ = ["held_force", "learnt_force", "learnt_walks", "scale_watch", "stated_scale"]
