"""Commissioning: small moves of the joint, watched, and the model that they identify.

Not here: the fit itself (calibration). Begin with procedure.py.
"""

__all__ = ["live", "picture", "plan", "procedure", "verdict", "watch"]
