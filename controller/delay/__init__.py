"""Estimators of the capture delay, one file each."""
