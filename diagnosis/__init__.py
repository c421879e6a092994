"""Shows what a simulation gets wrong in measured data, names the cause, extends the model, measures the gain."""
