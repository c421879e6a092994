"""Several recordings of one driven rig, fitted together.

Here belongs what they ask for beside what one recording does: joining them, where each cause holds,
and the proof of each on what was learnt from the others. Begin to read at rig.py.
"""

__all__ = ["rig"]
