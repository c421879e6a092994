"""Emulators of the hardware. They speak the devices' own registers and frames, so that the real drivers run on them."""
