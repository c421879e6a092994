"""Fuzzing: coverage-guided of the decoders that read what others send; of the step with odd values and pauses."""
