"""The joint's own known motion, from the commands sent, and what it does to each sensor.

Not here: limits and commands (controller/command). Begin with joint_motion.py.
"""

__all__ = [
    "drive_model",
    "gear_play",
    "history",
    "joint_motion",
    "known_image_motion",
    "modal_response",
    "sensor_deflection",
]
