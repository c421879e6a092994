"""The cycle: one pure step function, and the loop, clock, devices and process around it.

Not here: what the step is made of (the packages beside this one). Begin with step.py; daemon.py is the process.
"""

__all__ = ["daemon", "live_devices", "loop", "realtime", "recorded", "schedule", "step", "warm_up"]
