"""Does the diagnosis find what is hidden? Blind trials, made by tests/hidden_world, which it does not know."""
