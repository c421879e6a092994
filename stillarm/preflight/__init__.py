"""The preflight: what is wrong with a machine and a rig, found without moving anything, and what to do about it."""
