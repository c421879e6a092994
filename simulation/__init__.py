"""The stand-in for the hardware: flexible arm, sensors, camera, in real time (rig) and in virtual time (simulate)."""
