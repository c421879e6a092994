"""Rig, supervisor and controller in one process and in virtual time: deterministic from a seed (`stillarm simulate`).

Not here: replay of a recording (controller/replay). Begin with virtual_time.py.
"""

__all__ = ["simulated_recording", "virtual_time"]
