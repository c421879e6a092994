"""Telemetry as a page draws it: decoded, packed into few bytes, with its age; and the present knowledge of the loop.

Not here: sockets to pages (server), files (recordings). Begin with `telemetry.py`.
"""

__all__ = [
    "beside",
    "beside_runner",
    "feed",
    "foxglove_bridge",
    "known",
    "listener",
    "packing",
    "telemetry",
    "view",
]
