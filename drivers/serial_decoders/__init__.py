"""Pure, incremental decoders for the frames of serial accelerometers, one file per device."""
