"""What may be wrong with a driven joint: the forms of each cause, and where their fits begin.

Not here: which of them is taken (search). Begin with mechanisms.py.
"""

__all__ = ["extents", "gaps", "mechanisms", "missing"]
