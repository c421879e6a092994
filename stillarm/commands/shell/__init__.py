"""Commands that serve the shell itself."""
