"""Where the first fit begins: from the data alone, by a subspace fit of the modes, or from what a model file states.

Not here: where the fit of a cause begins (mechanisms). Begin with start.py.
"""

__all__ = ["begins", "start", "stated"]
