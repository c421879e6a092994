"""Predictors of the present deflection from delayed samples, one file each."""
