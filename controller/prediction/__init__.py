"""Predictors of the present deflection from delayed samples, one file each. Delay estimators belong to `delay/`."""
