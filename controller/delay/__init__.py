"""Estimators of the capture delay, one file each. Predictors belong to `prediction/`."""
