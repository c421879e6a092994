"""Output of a simulated run: the truth beside the recording, a clock that jumps in it, the process that writes it.

Not here: the recording file (common/recording). Begin with truth.py.
"""

__all__ = ["clock_steps", "recording_process", "truth"]
