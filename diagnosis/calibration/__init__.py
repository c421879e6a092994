"""All of a model's parameters from one recording, whatever the model says.

Not here: causes (decision). Begin with calibrate.py.
"""

__all__ = ["calibrate", "start_values"]
