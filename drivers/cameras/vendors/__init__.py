"""Cameras that need their maker's package, each imported only where it is configured.

Not here: cameras that OpenCV opens, files. Begin with stream_camera.py: what all have in common; a new maker
is one backend.
"""

__all__ = [
    "aravis_camera",
    "basler_camera",
    "genicam_camera",
    "ids_peak_camera",
    "libcamera_camera",
    "stream_camera",
    "ueye_camera",
]
