"""What happens to the arm on the way: impacts, pulls that hold it, a frequency that changes.

Not here: what its sensors do (sensors), and causes that a model can be extended by (forms).
"""

__all__ = ["frequency_course", "impact_onsets", "impacts", "pulls"]
