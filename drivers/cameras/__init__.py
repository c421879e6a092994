"""Cameras behind one interface: live, from files, from another process.

Not here: what makers' own packages are needed for (vendors/). Begin with camera.py and camera_factory.py.
"""

__all__ = ["camera", "camera_factory", "file_camera", "frame_ring", "raw_video", "shared_memory_camera"]
