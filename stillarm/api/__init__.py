"""What `import stillarm` offers beside `diagnose`: recordings as arrays, replay, simulation, one's own estimator.

Not here: anything that the command line or a daemon needs. stillarm/__init__.py loads a name when it is asked for.
Begin with channels.py.
"""

__all__ = ["channels", "replaying", "simulating"]
