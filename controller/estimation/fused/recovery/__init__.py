"""Filters that are wrong and sure of it: tests of their consistency, and states to start them from again.

Not here: what is then changed in them: fusion/recovery.py. Begin with consistency.py.
"""

__all__ = ["consistency", "date_watch", "fresh_fit", "fresh_start"]
