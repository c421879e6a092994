"""The forms in which causes are fitted, and terms of free form that are held against them.

causes/ holds how those causes are looked for that need more than their declaration says. Not here: which form is tried
where, and which is best (search). Begin with cause.py, then catalogue.py.
"""

__all__ = [
    "catalogue",
    "cause",
    "causes",
    "delay_walk",
    "force_terms",
    "freeform",
    "sensor_walk",
]
