"""Values in, guesses out. Pure: no file, no clock. What cannot be known is "unknown". Begin with `look.py`."""

__all__ = ["column_look", "look"]
