"""Configuration, model and scenario files that come with the program."""
