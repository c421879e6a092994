"""How a grey box is fitted to the blocks that train it, and scored by bands of frequency.

Not here: where a fit begins (starts), and what a cause sets free (mechanisms). Begin with fitting.py.
"""

__all__ = ["bounds", "fitting", "freedom", "gauss_newton", "scoring", "showing"]
