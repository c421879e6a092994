"""The simulated camera: when it exposes and hands over, what it sees, and the process that renders it.
docs/simulated-camera.md

Not here: tracking (supervisor/tracking). Begin with camera_timing.py, then renderer.py.
"""

__all__ = ["camera_process", "camera_timing", "pose_history", "virtual_camera"]
