"""The stand-in for the hardware: flexible arm, sensors, camera, in real time (rig) and in virtual time (simulate).

Not here: anything that the controller or the supervisor needs on a real rig. Begin with arm/plant.py, then
virtual_time/virtual_time.py.
"""
