"""How the vector is fitted to the channels, and what a fit is worth: its log score, its noise, where it departs.

Not here: what a fit may be of (events, sensors, forms). Begin with fit.py, then evidence.py.
"""

__all__ = ["band_score", "channel_noise", "departures", "evidence", "fit", "fitted", "gains", "peaks", "rest"]
