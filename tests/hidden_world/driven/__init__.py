"""Recordings of joints that a torque, a current or a voltage drives, with at most one hidden cause, as a stranger would
hand them over. Shares no code with the program, nor with the worlds beside it.

Begin at draw.py; `python -m tests.hidden_world.driven.write OUT --count N --seed S` writes cases with their truth.
"""
