"""The methods: from what the sensors show to the delay and the present deflection. docs/methods.md

A method takes an Observation and returns an Estimate (estimate.py); methods.py is the table of them. Not
here: what is done
with an estimate (controller/command). Begin with estimate.py, then sine_method.py, the paper's method.
"""

__all__ = ["delay", "estimate", "methods", "sine_method"]
