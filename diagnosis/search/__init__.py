"""All forms held against each other on top of one fit: the baseline, score tests, refits, and what convinces.

Not here: what is taken in the end, round by round, and what is said of it (decision). Begin with comparison.py.
"""

__all__ = [
    "baseline",
    "begun",
    "candidates",
    "carried",
    "comparison",
    "convincing",
    "early_baseline",
    "refits",
    "screen",
    "starts",
    "stated_baseline",
    "walks",
    "whitened",
]
