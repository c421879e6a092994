"""What a cycle reads: sensors, the supervisor's samples, the operator; each value checked once, here.

Not here: what is concluded from it. Begin with cycle_input.py, then plausible_input.py.
"""

__all__ = ["cycle_input", "exchange", "operator_input", "plausible_input"]
