"""Adapters to real parts: accelerometers, cameras, drives, and emulators that speak the parts' own registers."""
