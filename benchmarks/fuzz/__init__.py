"""Coverage-guided fuzzing of the decoders that read what others send."""
