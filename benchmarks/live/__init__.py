"""Demos in real time, one after another, each scored against its own truth: what anybody's machine gives.

Here belong the runs, what is busy beside them, and scores that read a truth file and a replay's tables. Scores know
nothing of how a method works. Begin at run.py.
"""
