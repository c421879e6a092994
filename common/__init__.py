"""What both computers share: model, configuration, protocol, shared memory, recording. Knows no device."""
