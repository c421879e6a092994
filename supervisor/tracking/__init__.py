"""Feature tracking against key frames: images in, displacements with covariance out. Pure; docs/tracking.md
explains."""
