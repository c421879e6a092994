"""What a recording of a driven joint holds: input and outputs, blocks, and the joint's motion by regression.

Not here: any simulation (greybox). Begin with signals.py.
"""

__all__ = ["blocks", "own", "regression", "signals", "stack"]
