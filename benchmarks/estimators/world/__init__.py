"""The benchmark's own world: laws of motion and timing, and the data drawn from them. It imports nothing of
what it judges.

Not here: scores and tables. Begin with regimes.py, then generator.py.
"""
