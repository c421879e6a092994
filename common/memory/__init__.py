"""Memory shared between processes by name, what a killed process leaves of it, and keeping a process's
memory where it is.

Not here: what is laid out in a block (the module that owns the block says it). Begin with shared_memory.py.
"""

__all__ = ["left_behind", "shared_memory", "steady_memory"]
