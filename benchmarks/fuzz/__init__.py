"""Fuzzing: coverage-guided for the decoders of external input; with odd values and pauses for the controller's step."""
