"""Feature tracking against key frames: images in, displacements with covariance out (docs/tracking.md). Pure.

Begin with `tracker.py`. Camera, clock and datagrams do not belong here.
"""

__all__ = ["tracker"]
