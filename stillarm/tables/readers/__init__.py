"""One file a format: bytes in, a `TableFile` out. No guessing at what a column means. Begin with `read_file.py`."""

__all__ = ["read_file"]
