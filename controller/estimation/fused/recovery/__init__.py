"""When the filters are wrong and sure of it: tests of their consistency, and what they are begun anew from.

Not here: what is then changed in them: fusion/recovery.py. Begin with consistency.py.
"""

__all__ = ["consistency", "date_watch", "fresh_fit", "fresh_start"]
