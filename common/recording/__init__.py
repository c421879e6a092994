"""The recording file: which topics it holds, how it is written, read back and mended.

Not here: the process that writes while a daemon runs (common/recorder), CSV (common/csv_bundle). Begin with topics.py.
"""

__all__ = ["header", "reader", "recover", "topics", "writer"]
