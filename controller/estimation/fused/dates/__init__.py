"""When frames were exposed: count, stamps, arrivals and n_i, and which law of them the images bear out.

Not here: what an image shows: filters/image_update.py. Begin with frame_dates.py.
"""

__all__ = ["evidence", "frame_dates"]
