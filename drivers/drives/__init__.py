"""Drives behind one interface: a joint velocity in, the joint's state out. Here too is the reference end of
the UDP gateway.

Not here: limits and damping (controller/command). Begin with drive.py and drive_factory.py.
"""

__all__ = [
    "cia402_set_up",
    "cia402_states",
    "drive",
    "drive_factory",
    "drive_gateway",
    "drive_gateway_socket",
    "odrive_lines",
    "udp_gateway_drive",
    "velocity_loop",
]
