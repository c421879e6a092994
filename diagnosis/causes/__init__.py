"""The catalogue: one file for each cause that the simulation can be extended by."""
