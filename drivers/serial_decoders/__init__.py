"""Frames of serial accelerometers: pure, incremental decoders."""
