"""What is told: diagnosis.json, the extended model, what that is worth in use, and one self-contained page.

Not here: anything that changes the verdict. Begin with result.py, summary.py and page.py.
"""

__all__ = [
    "drawing",
    "extended_model",
    "page",
    "picture",
    "result",
    "summary",
    "tables",
    "use",
    "words",
]
