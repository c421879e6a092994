"""Drivers of accelerometers, cameras and drives, each behind one interface, and emulators of their registers.

Begin with `accelerometer.py`, `camera.py` and `drive.py`. Estimation and control do not belong here.
"""
