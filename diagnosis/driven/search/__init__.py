"""Forms fitted round by round until nothing gains more than chance, and what each is worth.

Not here: what is said of them (decision). Begin with search.py.
"""

__all__ = ["from_start", "judging", "removal", "rests", "search", "slow"]
