"""What a recording shows that the simulation does not, why, and a model that does. docs/diagnosis.md

data -> physics -> inference -> decision -> report: each imports only those before it. calibration and commissioning
stand on inference. Not here: the simulation of rendered images and processes. Begin with diagnose.py; from Python
with notebook.py.
"""

__all__ = [
    "calibration",
    "commissioning",
    "data",
    "decision",
    "diagnose",
    "driven",
    "notebook",
    "physics",
    "report",
]
