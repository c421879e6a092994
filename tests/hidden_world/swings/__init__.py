"""Recordings of swings for judging estimators: pulls, pushes, strikes, joint moves, late images, with the truth.

Shares no code with the program. Here belong the rig, its motion, its sensors and the arrivals of its images, drawn
from a seed. Begin at draw.py; `python -m tests.hidden_world.swings.write OUT --count N --seed S` writes bundles.
"""
