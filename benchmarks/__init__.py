"""The benchmarks that regenerate the documentation's tables; `stillarm benchmark NAME` runs them.

Each subpackage is one benchmark, with its own judge. Begin with its `run.py`.
"""
