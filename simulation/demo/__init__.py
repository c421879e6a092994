"""The demonstration: all processes in real time, then replay, scores against the truth, figures."""
