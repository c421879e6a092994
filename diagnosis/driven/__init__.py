"""Joints that a torque, a current or a voltage drives, diagnosed from input and output.

Here belongs what such rigs need: their channels, the grey box with its numbers, how that is fitted, which forms a cause
has there, the verdict and the page. Joints that follow a velocity command are in search and decision. The equations
of motion are stillarm.simulation.arm.torque_joint. Begin to read at diagnosed.py.
"""

__all__ = ["diagnosed", "foretold", "page", "recording", "together"]
