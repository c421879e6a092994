"""The supervisor: captures frames, tracks features, and sends the displacement of each image with its timestamp.

It is not real-time. `daemon.py` is the process, `step.py` the step from a frame to a visual sample.
"""
