"""What was measured: a recording on a grid of cycles, its channels, its noise, and the times of its frames.

Not here: what should have been measured (physics), and anything that is fitted to a simulation. Begin with
measured.py.
"""

__all__ = [
    "channels",
    "frame_clock",
    "frame_times",
    "lost_frames",
    "measured",
    "noise",
    "reading",
    "robust",
    "split",
]
