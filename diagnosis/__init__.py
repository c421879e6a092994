"""What a recording shows that the simulation does not, why, and a model that does. docs/diagnosis.md

Not here: the simulation of rendered images and processes. Begin with diagnose.py.
"""
