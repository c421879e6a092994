"""Cameras behind one interface: live, from files, from another process.

Not here: what makers' own packages are needed for (vendors/). Begin with camera.py and camera_factory.py.
"""

__all__ = ["camera", "camera_factory", "frame_ring", "shared_memory_camera"]
