"""Starting and ending processes, their place in the scheduler, signals, systemd.

Not here: memory between processes (common/memory), log lines (common/recorder). Begin with child_process.py.
"""

__all__ = [
    "blas_threads",
    "child_process",
    "loop_processor",
    "parent_death",
    "priority",
    "service_notify",
    "single_instance",
    "stop_signal",
]
