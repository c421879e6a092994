"""Kalman filters over two time scales, with measurements applied at their own, earlier time."""
