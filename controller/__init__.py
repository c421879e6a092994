"""The 1 ms cycle: estimate the capture delay, predict the present deflection, damp it by the joint."""
