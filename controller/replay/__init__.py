"""A recording through the controller's own step, and the tables that come of it.

Not here: simulation in virtual time (simulation/virtual_time). Begin with replay.py.
"""

__all__ = ["followed_method", "frame_delays", "replay", "replay_tables"]
