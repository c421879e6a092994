"""Estimators of the capture delay, one file each.

Not here: predictors. Begin with correlation.py, the paper's eq. 2 to 11.
"""

__all__ = ["constant", "correlation", "timestamps"]
