"""Points of two images matched to each other, and the one rigid displacement that they give.

Not here: which images are matched, and where the scene is sought (supervisor/tracking). Begin with flow.py.
"""

__all__ = ["features", "flow", "interpolation_bias", "photometry", "prepared_image", "rigid_displacement"]
