"""Memory shared between processes by name, its removal after a killed process, and locking a process's memory.

Not here: what is laid out in a block (the module that owns the block says it). Begin with shared_memory.py.
"""

__all__ = ["left_behind", "shared_memory", "steady_memory"]
