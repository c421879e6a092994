"""What a recording shows that the simulation does not, why, and a model that does. docs/diagnosis.md

data -> physics -> fitting -> events -> sensors -> forms -> search -> decision -> report: each imports only those before
it. calibration and commissioning stand on search; driven is the way of joints that a torque, a current or a voltage
drives. Not here: the simulation of rendered images and processes. Begin with diagnose.py; from Python with notebook.py.
"""

__all__ = [
    "calibration",
    "commissioning",
    "data",
    "decision",
    "diagnose",
    "driven",
    "events",
    "fitting",
    "forms",
    "notebook",
    "physics",
    "report",
    "search",
    "sensors",
]
