"""Scores delay estimators and predictors on data from an independent generator; docs/benchmark-estimators.md."""
