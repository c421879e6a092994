"""Several recordings of one driven rig, fitted together.

Here belongs what they ask for beside what one recording does: joining them, causes that hold in some of them only,
and the proof of each on what was learnt from the others. Begin to read at joining.py.
"""

__all__ = ["forms", "joining", "proof"]
