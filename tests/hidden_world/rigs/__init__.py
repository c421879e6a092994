"""Recordings of a second world with a hidden effect, for judging `stillarm diagnose`: rigs, moves, noises, forms of
effects drawn more widely than any one rig is likely. Shares no code with the program, nor with the world beside it.

Begin at draw.py; `python -m tests.hidden_world.rigs.write OUT --count N --seed S` writes bundles with their truth.
"""
