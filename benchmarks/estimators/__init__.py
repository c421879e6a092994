"""Delay estimators and predictors, judged on data from a generator of their own; docs/benchmark-estimators.md."""
