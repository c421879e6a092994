"""The demonstration: all processes in real time, then replay, scores against the truth, figures.

Not here: the live benchmark (benchmarks/live), which runs demos. Begin with demo.py.
"""

__all__ = ["attended", "demo", "own_folder", "processes", "ring_down", "set_up"]
