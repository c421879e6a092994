"""The supervisor killed while the arm swings, and what each method makes of its successor.

Not here: the live benchmark without kills (benchmarks/live). Begin with kill_run.py.
"""
