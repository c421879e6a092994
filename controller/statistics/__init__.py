"""What the loop tells of itself: counters and histograms in shared memory, overruns and their likely cause.

Not here: recordings (loop/recorded.py says what of a cycle is recorded). Begin with loop_block.py.
"""

__all__ = ["histogram", "loop_block", "overrun", "statistics_process"]
