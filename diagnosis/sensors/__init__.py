"""What sensors and clocks do to the data: values that are not the arm's, late and lost frames, stamps that are wrong.

Not here: what changes a mean and is fitted as a form (forms). Begin with laws.py.
"""

__all__ = ["accelerometer_faults", "clocks", "image_dating", "late_bursts", "laws"]
