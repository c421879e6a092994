"""Devices that stand in for hardware: they speak the device's own registers, so that the real driver runs on
them."""
