"""One frame and the blocks before it on their way through the filters, and what is done where they do not fit.

Not here: in which cycle each step happens: frame_steps.py. Begin with fusion.py.
"""

__all__ = ["fusion", "state"]
