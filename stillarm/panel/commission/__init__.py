"""Commissioning in the page: what each step does and how far it moves, and the commands that do it.

`steps.py` is pure; `bench.py` starts `stillarm check` and `stillarm commission`.
"""

__all__ = ["bench"]
