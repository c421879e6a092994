"""Every method beside the limit that physics sets. docs/benchmark-estimators.md

Not here: real processes (benchmarks/live). Begin with run.py; world/ makes the data and knows nothing of the program.
"""
