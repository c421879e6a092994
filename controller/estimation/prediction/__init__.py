"""Predictors of the present deflection from delayed samples, one file each.

Not here: estimators of the delay. Begin with sine_regression.py.
"""

__all__ = ["exact_regression", "image_offset", "sine_regression"]
