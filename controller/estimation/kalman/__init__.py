"""Kalman filters over two time scales, with measurement updates at the measurements' own, earlier time.

Begin with `kalman_method.py`. The method `fused` has its own filters in `fused/`.
"""

__all__ = ["fast_sensor", "kalman_method"]
