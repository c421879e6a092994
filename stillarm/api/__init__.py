"""The Python interface beside `diagnose`: recordings as arrays, replay, simulation, an estimator of your own.

Not here: anything that the command line or a daemon needs. stillarm/__init__.py loads a name when it is asked for.
Begin with channels.py.
"""

__all__ = ["channels", "replaying", "simulating"]
