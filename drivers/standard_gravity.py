"""The unit in which accelerometers count."""

STANDARD_GRAVITY_M_S2 = 9.80665
