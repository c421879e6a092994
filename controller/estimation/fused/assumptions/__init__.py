"""What the method assumes: each number once, with its unit and its origin.

Not here: settings, which are in common/files/configuration.py. Begin with assumptions.py.
"""

__all__ = ["assumptions", "filter_assumptions", "sensor_assumptions"]
