"""When frames were exposed, by count, stamps, arrivals and n_i; and which of these laws the images support.

Not here: what an image shows: filters/image_update.py. Begin with frame_dates.py.
"""

__all__ = ["evidence", "frame_dates"]
