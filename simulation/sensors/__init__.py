"""The simulated accelerometer: from the tip's true acceleration to what the configured device reports.

Not here: the camera (simulation/camera), registers (drivers/emulated_chips). Begin with accelerometer_signal.py.
"""

__all__ = ["accelerometer_effects", "accelerometer_model", "accelerometer_reading", "accelerometer_signal"]
