"""`fused`: accelerometer, image, frame counter, stamps, arrivals and joint motion in one estimator. docs/fused.md

Not here: the other methods. Begin with method.py.
"""

__all__ = ["method"]
