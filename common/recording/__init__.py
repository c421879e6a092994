"""Recordings: what is recorded (topics), how it is written, read back, imported and exported."""
