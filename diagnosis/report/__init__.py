"""What is told: diagnosis.json, the extended model, what that is worth in use, and one self-contained page.

Not here: anything that changes the verdict. Begin with diagnosis.py and page.py.
"""

__all__ = ["diagnosis", "extended_model", "page", "tables", "use", "words"]
