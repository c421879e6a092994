"""Commands that run, check, identify or operate a rig, real or simulated."""
