"""Which of what the search took is needed in the final model, what else explains it as well, and what is left.

Not here: the words and the page (diagnosed.py, page.py). Begin with decide.py.
"""

__all__ = ["decide"]
