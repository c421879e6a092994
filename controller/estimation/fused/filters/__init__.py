"""Ten extended Kalman filters as one array: their states, and every way in which these change.

Not here: which filter is believed: dates/evidence.py. Begin with laws.py, then bank.py.
"""

__all__ = [
    "bank",
    "block_update",
    "date_update",
    "image_update",
    "jumps",
    "laws",
    "new_beginning",
    "start",
]
