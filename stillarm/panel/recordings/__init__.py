"""Recordings in the page: the list of a folder, a recording as columns on disk, and jobs in processes of their own.

`decimation.py` is pure; `extract.py` is a process. The panel's own process never holds a recording in memory.
"""

__all__ = ["jobs", "library"]
