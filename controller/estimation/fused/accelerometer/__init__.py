"""The accelerometer by itself: samples and blocks, the sensor's health, and impacts that it measures.

Not here: how blocks correct the filters: filters/block_update.py. Begin with blocks.py.
"""

__all__ = ["blocks", "impact_detector", "impact_meter", "sensor_health"]
