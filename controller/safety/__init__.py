"""Decides whether the arm may move and be damped: states, transitions, and the tests behind them.

Begin with `table.py` and `machine.py`; `supervision.py` is the interface for the step.
"""

__all__ = ["adjusting", "health", "machine", "supervision", "table"]
